# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Motors, tips, sections and bases by name: schema, documentation, and kinds of one's own."""

import json
import re
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import ClassVar

import jsonschema
import numpy as np
import pytest
from helpers.yaml_content import shipped_content
from hypothesis import given, settings
from hypothesis import strategies as st

from cpr_core import DescriptionError, InvalidRequest, load_robot, solve_forward, solve_home
from cpr_core.description.chain import Turn
from cpr_core.description.chain_joints import CHAIN_JOINTS
from cpr_core.description.description_schema import description_schema
from cpr_core.description.joints import JOINTS, Fixed, Joint
from cpr_core.description.loads import Loads
from cpr_core.description.motors import MOTORS, UNDRIVEN, Drive, Motor
from cpr_core.description_part import Part, field, triple
from cpr_core.lie import rotation_exp
from cpr_core.model.model_state import evaluate
from cpr_core.model.robot import Robot
from cpr_core.model.shape import rod_bases
from cpr_core.rods.rod import MOST_MODES, StrainModes
from cpr_core.rods.sections import SECTIONS, RectangularSection, Section
from cpr_core.rods.strain_basis import STRAIN_BASES, DescribedBasis

ROOT = Path(__file__).parents[3]
FAMILIES = {
    "motor": MOTORS,
    "tip": JOINTS,
    "section": SECTIONS,
    "strain": STRAIN_BASES,
    "joint": CHAIN_JOINTS,
}
#: Where the schema has them, and the field that says which one it is, where it is not ``type``.
IN_SCHEMA = {family: family for family in FAMILIES} | {"joint": "chain_element"}
CHOSEN_BY = {"section": "shape", "strain": "basis", "joint": "joint"}


# The schema and the documentation.


def test_the_schema_for_editors_is_what_the_classes_declare():
    file = resources.files("cpr_core.description").joinpath("description.schema.json")
    assert json.loads(file.read_text("utf-8")) == description_schema(), (
        "run tools/description_schema.py"
    )


def test_as_many_modes_may_be_asked_for_as_described():
    assert load_robot("rfrfr", modes=MOST_MODES).state_size > 2 * MOST_MODES
    for modes in (MOST_MODES + 1, 10**400):
        with pytest.raises(InvalidRequest, match=f"modes: expected at most {MOST_MODES}, got"):
            load_robot("rfrfr", modes=modes)
        described = shipped_content("rfrfr") | {"strain": {"bending_3": modes}}
        with pytest.raises(DescriptionError, match=r"strain\.bending_3: expected"):
            load_robot(described)


def words_of_schema(node):
    """Names of fields, and words they can be."""
    found = set()
    if isinstance(node, dict):
        found |= {*node.get("properties", ())}
        found |= {word for word in node.get("enum", ()) if isinstance(word, str)}
        for value in node.values():
            found |= words_of_schema(value)
    elif isinstance(node, list):
        for value in node:
            found |= words_of_schema(value)
    return found


def section_of_descriptions():
    """The one section of the documentation where the tables of descriptions are."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    sections = [
        section
        for page in pages
        for section in re.split(r"^## ", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
        if "\n| `motor.type` |" in section
    ]
    assert len(sections) == 1
    return sections[0]


def documented_rows():
    """Rows of its tables."""
    return [line for line in section_of_descriptions().splitlines() if line.startswith("| ")]


def words_of_row(row):
    """Words in code: `motor.limits.position` is three, `spin: true` one, `leg1` is leg."""
    return {
        word.rstrip("0123456789[]") if word.startswith("leg") else word.rstrip("[]")
        for code in re.findall(r"`([^`]+)`", row)
        for word in code.split(":")[0].split(".")
    }


def test_all_that_can_be_described_is_documented_and_nothing_else():
    documented = set().union(*map(words_of_row, documented_rows()))
    possible = words_of_schema(description_schema())
    assert possible - documented == set()
    assert documented - possible == set()


@pytest.mark.parametrize(
    ("family", "first"),
    [("motor", "motor.type"), ("tip", "tip.type"), ("section", "section.shape")],
)
def test_every_kind_is_documented_beside_its_fields(family, first):
    rows = [row for row in documented_rows() if row.startswith(f"| `{first}` |")]
    assert len(rows) == 1
    more = [row for row in documented_rows() if row.startswith("| `section.")]
    text = words_of_row("".join(rows + (more if family == "section" else [])))
    for name, kind in FAMILIES[family].items():
        assert {name, *kind.fields} - {"position"} <= text, name


@pytest.mark.parametrize("name", CHAIN_JOINTS)
def test_every_joint_of_chains_is_documented_under_its_name(name):
    parts = re.split(r"^#### ", section_of_descriptions(), flags=re.MULTILINE)[1:]
    [part] = [part for part in parts if name in part.partition("\n")[0].lower()]
    assert f"{{joint: {name}, " in part
    rows = [line for line in part.splitlines() if line.startswith("| `")]
    assert {*CHAIN_JOINTS[name].fields} <= words_of_row("".join(rows))


@pytest.mark.parametrize("family", FAMILIES)
def test_required_fields_are_fields(family):
    for kind in FAMILIES[family].values():
        assert {*kind.required} <= {*kind.fields}
        assert all(meaning.get("description") for meaning in kind.fields.values())


def missing_and_refused(family, content):
    """Fields that the schema asks for beside these, and those of these that it does not know."""
    where = {"$ref": f"#/$defs/{IN_SCHEMA[family]}", "$defs": description_schema()["$defs"]}
    missing, refused = set(), set()
    for error in jsonschema.Draft202012Validator(where).iter_errors(content):
        match error.validator:
            case "required":
                missing |= {*error.validator_value} - {*content}
            case "additionalProperties":
                refused |= {*content} - {*error.schema["properties"]}
            case "not":
                refused.add(error.absolute_path[-1])
    return missing, refused


@pytest.mark.parametrize("family", FAMILIES)
def test_the_schema_asks_for_what_a_kind_requires_and_refuses_what_only_others_have(family):
    every = {name for kind in FAMILIES[family].values() for name in kind.fields}
    for name, kind in FAMILIES[family].items():
        chosen = {CHOSEN_BY.get(family, "type"): name}
        missing, refused = missing_and_refused(family, chosen)
        assert (missing, refused) == ({*kind.required}, set()), name
        missing, refused = missing_and_refused(family, dict.fromkeys(every) | chosen)
        assert (missing, refused) == (set(), every - {*kind.fields}), name


# Kinds of one's own.


@dataclass(frozen=True)
class Tangential(Motor):
    """Turns about the tangent of a circle around z."""

    angle: float
    actuated = "turn"
    unit = "rad"
    fields: ClassVar = {"angle": {"type": "number", "description": "where on the circle [rad]"}}
    required = ("angle",)

    @classmethod
    def from_description(cls, part):
        if part.planar:
            raise part.fail("type", "circles are for space")
        return cls(part.number("angle"))

    def turn_axis(self, base_rotation):
        return (-np.sin(self.angle), np.cos(self.angle), 0.0)


@dataclass(frozen=True)
class OnCircle(Joint):
    """Ball joint on a circle."""

    fields: ClassVar = {"radius": field("positive", "[m]"), "angle": {"type": "number"}}
    required = ("radius", "angle")

    @classmethod
    def from_description(cls, part):
        angle = part.number("angle")
        return cls(triple(part.number("radius") * np.array([np.cos(angle), np.sin(angle), 0.0])))


@dataclass(frozen=True)
class Square(Section):
    """Solid square."""

    side: float
    fields: ClassVar = {"side": field("positive", "[m]")}
    required = ("side",)

    def rigidities(self, young_modulus, shear_modulus):
        return RectangularSection(self.side, self.side).rigidities(young_modulus, shear_modulus)

    def mass_per_length(self, density):
        return density * self.side**2

    def bending_strain(self, bending_2, bending_3):
        return 0.5 * self.side * (np.abs(bending_2) + np.abs(bending_3))


@dataclass(frozen=True)
class Shifted(DescribedBasis):
    """Powers of the distance from a place."""

    place: float
    fields: ClassVar = {"place": {"type": "number", "description": "s/l; default 0"}}

    @classmethod
    def from_description(cls, part):
        return cls(part.number("place", 0.0))

    def values(self, sigma, modes):
        return np.vander(sigma - self.place, modes, increasing=True)


@pytest.fixture
def own(monkeypatch):
    monkeypatch.setitem(MOTORS, "tangential", Tangential)
    monkeypatch.setitem(JOINTS, "on_circle", OnCircle)
    monkeypatch.setitem(SECTIONS, "square", Square)
    monkeypatch.setitem(STRAIN_BASES, "shifted", Shifted)


def test_kinds_of_ones_own_are_described_built_and_solved(own):
    content, same = shipped_content("three_rfs"), shipped_content("three_rfs")
    content["rod"]["section"] = {"shape": "square", "side": 0.002}
    same["rod"]["section"] = {"shape": "rectangular", "width": 0.002, "height": 0.002}
    content["strain"] |= {"basis": "shifted", "place": 0.4}
    for leg in content["legs"]:
        angle = float(np.arctan2(*leg["base"]["position"][1::-1]))
        leg["motor"] = {"type": "tangential", "angle": angle, "limits": leg["motor"]["limits"]}
        leg["tip"] = {"type": "on_circle", "radius": 0.1, "angle": angle}
        leg["base"]["normal"] = [-np.sin(angle), np.cos(angle), 0.0]
    robot, expected = load_robot(content), load_robot(same)
    assert isinstance(robot.description.legs[1].motor, Tangential)
    motors = solve_home(expected).motors + [0.1, -0.05, 0.08]
    found, wanted = solve_forward(robot, motors), solve_forward(expected, motors)
    np.testing.assert_allclose(found.platform_position, wanted.platform_position, atol=1e-8)
    np.testing.assert_allclose(found.efforts, wanted.efforts, atol=1e-7)


@pytest.mark.parametrize(
    ("spoil", "field_name", "says"),
    [
        (lambda leg: leg["motor"].pop("angle"), "legs[0].motor", "missing field 'angle'"),
        (lambda leg: leg["motor"].update(axis=[0, 0, 1]), "legs[0].motor", "unknown field 'axis'"),
        (lambda leg: leg["tip"].update(radius=-1), "legs[0].tip.radius", "above 0"),
        (lambda leg: leg["tip"].update(type="ball"), "legs[0].tip.type", "on_circle"),
    ],
)
def test_mistakes_in_kinds_of_ones_own_name_the_field(own, spoil, field_name, says):
    content = shipped_content("three_rfs")
    for leg in content["legs"]:
        leg["motor"] = {"type": "tangential", "angle": 0.3}
        leg["tip"] = {"type": "on_circle", "radius": 0.1, "angle": 0.3}
    load_robot(content)
    spoil(content["legs"][0])
    with pytest.raises(DescriptionError) as caught:
        load_robot(content)
    assert caught.value.field == field_name
    assert says in caught.value.problem


def test_a_kind_that_is_not_registered_any_more_is_refused():
    content = shipped_content("three_rfs")
    content["legs"][0]["motor"] = {"type": "tangential", "angle": 0.3}
    with pytest.raises(DescriptionError, match="expected one of revolute, prismatic"):
        load_robot(content)


def test_fields_of_another_basis_are_refused():
    content = shipped_content("rfrfr")
    content["strain"] = {"basis": "chebyshev", "degree": 3}
    with pytest.raises(DescriptionError, match=r"strain\.degree: chebyshev has no such field"):
        load_robot(content)


# The base of a leg: the kernels and `LegDescription.base_pose` agree.

numbers = st.floats(-3.0, 3.0)
vectors = st.tuples(numbers, numbers, numbers)


@pytest.mark.parametrize("planar", [False, True])
@pytest.mark.parametrize("spin", [False, True])
@pytest.mark.parametrize("kind", MOTORS)
@settings(deadline=None, max_examples=25)
@given(turned=vectors, place=vectors, axis=vectors, turn=numbers, shift=st.floats(0.1, 2.0))
def test_the_kernels_hold_the_base_where_its_pose_says(
    kind, spin, planar, turned, place, axis, turn, shift
):
    if spin and ("spin" not in MOTORS[kind].fields or planar):
        return
    if planar:
        turned, place = (0.0, 0.0, turned[2]), (*place[:2], 0.0)
        axis = (*axis[:2], 0.0) if kind == "prismatic" else (0.0, 0.0, 1.0)
    axis = (
        np.array(axis) if np.linalg.norm(axis) > 0.1 else np.eye(3)[0 if planar else 2]
    ).tolist()
    motor = MOTORS[kind].from_description(Part("test", "", {"axis": axis, "spin": spin}, planar))
    description = load_robot("planar_body" if planar else "six_rfs").description
    leg = replace(
        description.legs[0],
        motor=motor,
        drive=Drive("motor") if motor.actuated else UNDRIVEN,
        joint=Fixed((0.1, -0.05, 0.0)),
        modes=StrainModes((0, 0, 3) if planar else (1, 2, 3)),
        base_position=np.array(place),
        base_rotation=rotation_exp(turned),
    )
    robot = Robot(replace(description, legs=(leg,), point_platform=False))
    state = np.zeros(len(robot.kernel_arrays.unit))
    for element, index in zip(leg.chain, robot.numbers.legs[0].coordinates, strict=True):
        if index is not None:
            state[index] = turn if isinstance(element, Turn) else shift
    # A straight rod ends where its base points; the platform is at the origin.
    residual = evaluate(
        robot, robot.load_arrays(Loads.none()), state, np.eye(3), np.zeros(3)
    ).residual[robot.multiplier_indices]
    base = leg.base_pose(turn, shift)
    held = robot.kernel_arrays.position_axes
    tip = base.position + base.length * base.rotation[:, 0]
    gap = np.array(leg.joint.position)[held] - tip[held]
    np.testing.assert_allclose(residual[: len(held)], gap, atol=1e-12)
    orientation = [np.sum(m * base.rotation) for m in leg.joint.orientation(planar)]
    np.testing.assert_allclose(residual[len(held) :], orientation, atol=1e-12)
    for found, expected in zip(rod_bases(robot, state)[0][0], base, strict=False):
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)
    if motor.actuated:
        for found, expected in zip(
            leg.base_at(state[-1]),
            leg.base_pose(*((turn, 0.0) if motor.actuated == "turn" else (0.0, shift))),
            strict=True,
        ):
            np.testing.assert_array_equal(found, expected)
