# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Natural units of a robot do not depend on how its rods are cut or fitted."""

from copy import deepcopy

import numpy as np
import pytest
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_home
from cpr_core.model.assessment import Assessment


def in_pieces(name, pieces):
    """A planar shipped robot, every rod of it in pieces of equal length."""
    described = shipped_content(name)
    rod = {"rod": {"length": described["rod"]["length"] / pieces}}
    for number, leg in enumerate(described["legs"]):
        joint = {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number + 1}"}
        del leg["motor"]
        leg["chain"] = [joint, *([rod] * pieces)]
    return load_robot(described)


def test_natural_units_do_not_depend_on_how_a_rod_is_cut():
    """Rods in halves had half the length and twice the energy: warnings were twice as far away."""
    whole = in_pieces("rfrfr", 1)
    found = Assessment(solve_home(whole))
    for pieces in (2, 3):
        cut = in_pieces("rfrfr", pieces)
        assert cut.mean_length == pytest.approx(whole.mean_length, rel=1e-14)
        assert cut.kernel_arrays.energy_unit == pytest.approx(
            whole.kernel_arrays.energy_unit, rel=1e-14
        )
        np.testing.assert_allclose(cut.motor_units, whole.motor_units, rtol=1e-14)
        again = Assessment(solve_home(cut))
        assert again.margin == pytest.approx(found.margin, rel=5e-3)
        for name in ("forward_singularity", "inverse_singularity"):
            assert again.value(name) == pytest.approx(found.value(name), rel=0.1), (name, pieces)


def test_a_stiff_fitting_decides_no_natural_unit():
    """A thick stub of 3 cm made the unit of energy 600 times as large: the node would have halted."""
    described = shipped_content("rfrfr")
    plain = load_robot(deepcopy(described))
    fitting = {"length": 0.03, "density": 0, "section": {"shape": "circular", "radius": 0.005}}
    for number, leg in enumerate(described["legs"]):
        joint = {"joint": "revolute", "axis": [0, 0, 1], "motor": f"motor{number + 1}"}
        del leg["motor"]
        leg["chain"] = [joint, {"rod": fitting, "strain": {"bending_3": 1}}, {"rod": {}}]
    fitted = load_robot(described)
    assert fitted.mean_length == pytest.approx(1.03 * plain.mean_length)
    assert fitted.kernel_arrays.energy_unit == pytest.approx(
        plain.kernel_arrays.energy_unit, rel=1e-3
    )
    both = [Assessment(solve_home(robot)) for robot in (plain, fitted)]
    for name in ("forward_singularity", "inverse_singularity"):
        first, second = (found.value(name) for found in both)
        assert second == pytest.approx(first, rel=0.2), name
