# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One robot spoilt in many ways: the error names the field."""

import pytest
from helpers.cantilever import cantilever
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot

BAD = {
    "spin that nothing holds": (
        "legs[0].motor.spin",
        lambda c: c["legs"][0].update(
            motor={"type": "extensible", "spin": True},
            tip={"type": "spherical", "position": [0, 0, 0]},
        ),
    ),
    "misspelt field": (
        "rod",
        lambda c: c["rod"].update(lenght=c["rod"].pop("length")),
    ),
    "force at the tip": (
        "loads.points[0].at",
        lambda c: c["loads"]["points"][0].update(at=1),
    ),
    "dangling leg": ("loads.points[0].leg", lambda c: c["loads"]["points"][0].update(leg="arm")),
    "tube without wall": (
        "rod.section.inner_radius",
        lambda c: c["rod"].update(
            section={"shape": "annular", "radius": 0.001, "inner_radius": 0.001},
            young_modulus=1e9,
            shear_modulus=1e9,
        ),
    ),
    "no modulus": (
        "rod",
        lambda c: c["rod"].update(section={"shape": "circular", "radius": 0.001}),
    ),
    "field of another section": ("rod.section", lambda c: c["rod"]["section"].update(radius=1.0)),
    "stations that fall": (
        "rod.profile.at",
        lambda c: c["rod"].update(profile={"at": [0, 0.7, 0.5, 1]}),
    ),
    "factors that are missing": (
        "rod.profile.stiffness",
        lambda c: c["rod"].update(profile={"at": [0, 0.5, 1], "stiffness": [1, 2]}),
    ),
    "limits reversed": (
        "legs[0].motor.limits.position",
        lambda c: c["legs"][0]["motor"].update(limits={"position": [1, -1]}),
    ),
    "tapered extensible leg": (
        "legs[0].motor.type",
        lambda c: (
            c["legs"][0].update(motor={"type": "extensible"}),
            c["rod"].update(profile={"at": [0, 1], "stiffness": [1, 2]}),
        ),
    ),
    "length that can vanish": (
        "legs[0].motor.limits.position",
        lambda c: c["legs"][0].update(
            motor={"type": "extensible", "limits": {"position": [0.0, 1.0]}}
        ),
    ),
    "spin of a revolute motor": (
        "legs[0].motor",
        lambda c: c["legs"][0]["motor"].update(spin=True),
    ),
    "wrong number of splines": (
        "strain",
        lambda c: c.update(strain={"basis": "bsplines", "degree": 3, "bending_3": 7}),
    ),
    "knots of polynomials": ("strain.knots", lambda c: c.update(strain={"knots": [0.5]})),
    "planar universal joint": (
        "legs[0].tip.type",
        lambda c: c["legs"][0].update(
            tip={"type": "universal", "position": [0, 0, 0], "axis": [1, 0, 0]}
        ),
    ),
    "planar rod curved out of the plane": (
        "rod.rest_curvature",
        lambda c: c["rod"].update(rest_curvature={"bending_2": [1.0]}),
    ),
    "force out of the plane": (
        "loads.points[0].force",
        lambda c: c["loads"]["points"][0].update(force=[0, 0, 1]),
    ),
    "more vectors than stations": (
        "loads.distributed[0].force",
        lambda c: c["loads"].update(
            distributed=[{"leg": "leg1", "at": [0, 1], "force": [[0, 1, 0]] * 3}]
        ),
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_descriptions_name_the_field(case):
    field, spoil = BAD[case]
    content = cantilever()
    del content["legs"][0]["rod"]
    content["legs"][0]["motor"] = {"type": "revolute", "axis": [0, 0, 1]}
    content["controlled"], content["home"]["motors"] = ["angle"], [0.0]
    content["loads"] = {"points": [{"leg": "leg1", "at": 0.4, "force": [0, 0.001, 0]}]}
    load_robot(content)
    spoil(content)
    with pytest.raises(DescriptionError) as caught:
        load_robot(content)
    assert caught.value.field == field, caught.value
    assert caught.value.problem


@pytest.mark.parametrize("tip", [{"type": "fixed", "tangent": [1, 0, 0]}, {"type": "revolute"}])
def test_spatial_tips_need_their_directions(tip):
    content = shipped_content("three_rfs")
    content["legs"][1]["tip"] = {"position": [0, 0.1, 0], **tip}
    with pytest.raises(DescriptionError, match=r"legs\[1\]\.tip: missing field '(normal|axis)'"):
        load_robot(content)
