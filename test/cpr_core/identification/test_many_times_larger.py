# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A number of which measurements say only that it is not small is doubted, whatever its deviation."""

import numpy as np
import pytest

import cpr_core
from cpr_core import CalibrationWarning, Measurement, StandardDeviations, calibrate

YOUNG = "rod.young_modulus"
OFFSETS = ["legs[0].chain[0].offset", "legs[1].chain[0].offset"]
DEVIATIONS = StandardDeviations(position=1e-5)
LEG = """
- base: {{position: [{x}, 0, 0], tangent: [0, 1, 0]}}
  chain:
  - {{joint: revolute, axis: [0, 0, 1], motor: {name}}}
  - {{link: [0.2, 0, 0]}}
  - {{joint: revolute, axis: [0, 0, 1], name: elbow_{name}}}
  - {{rod: {{}}}}
  tip: {{type: revolute, position: [0, 0, 0]}}"""
TEXT = (
    """
name: five_bars
space: planar
rod:
  length: 0.3
  section: {shape: circular, radius: 0.001}
  young_modulus: 60.0e+9
  shear_modulus: 24.0e+9
  density: 2000
strain: {bending_3: 5}
gravity: [0, -9.81, 0]
platform: {shape: point, mass: 0.05}
controlled: [x, y]
home: {motors: [0.6, -0.6], joints: {elbow_left: -1.0, elbow_right: 1.0}}
legs:"""
    + LEG.format(x=-0.1, name="left")
    + LEG.format(x=0.1, name="right")
)
#: Forces under which straight rods between hinges are next to buckling, or far from it.
PRESSED, FREE = -1.0, 0.0


def found_with(young, seed, forces=(PRESSED, FREE), bounds=None):
    """Young's modulus and two zeros, by rods whose sag is all that the modulus does."""
    robot = cpr_core.load_robot(TEXT)
    truth = robot.with_parameters({YOUNG: young})
    noise = np.random.default_rng(seed)
    rows = []
    for number in range(12):
        motors = np.array([0.6, -0.6]) + noise.uniform(0.0, 0.3, 2) * [1, -1]
        force = forces[number % len(forces)]
        loads = robot.default_loads.with_(wrench_world=[0, 0, 0, 0, force, 0])
        at = cpr_core.solve_forward(truth, motors, loads=loads)
        place = at.platform_position + noise.normal(0.0, 1e-5, 3) * [1, 1, 0]
        rows.append(Measurement(motors=motors, position=place, loads=loads))
    return calibrate(robot, rows, [YOUNG, *OFFSETS], DEVIATIONS, bounds=bounds)


@pytest.mark.parametrize(("seed", "force"), [(1, PRESSED), (1, -1.5), (3, -2.0)])
def test_a_modulus_that_is_only_known_not_to_be_small_is_doubted(seed, force):
    """It was told to a sixth, twice too small, and nothing was said: without end it fits as well."""
    with pytest.warns(CalibrationWarning, match=f"^{YOUNG} is hardly told: .* 5 times as large"):
        found = found_with(50e9, seed, (force, FREE))
    assert found.standard_deviations[0] < found.values[0] / 2.0
    assert len(found.doubts) == 1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_a_modulus_that_shows_is_told(seed):
    found = found_with(20e9, seed)
    assert abs(found.values[0] - 20e9) < 3.0 * found.standard_deviations[0]
    assert found.doubts == ()


@pytest.mark.filterwarnings("error")
def test_beyond_a_bound_no_number_is_tried():
    assert found_with(50e9, 1, bounds={YOUNG: (1e10, 1e11)}).doubts == ()


@pytest.mark.parametrize("seed", [2, 3])
def test_a_modulus_that_went_to_where_nothing_tells_it_is_doubted(seed):
    """It was twenty times what was described, named as not determined, and would have been written."""
    with pytest.warns(CalibrationWarning, match=f"^{YOUNG} is not determined at .* from 6e.10: "):
        found = found_with(50e9, seed)
    assert np.isinf(found.standard_deviations[0])
    assert found.values[0] > 10.0 * 60e9
    assert found.undetermined == (f"{YOUNG} is not determined",)


@pytest.mark.filterwarnings("error")
def test_a_modulus_that_nothing_tells_stays_without_a_doubt():
    robot = cpr_core.load_robot("rfrfr")
    at = [cpr_core.solve_forward(robot, [2.6 + 0.02 * k, 0.5 + 0.03 * k]) for k in range(5)]
    noise = np.random.default_rng(0)
    places = [each.platform_position + noise.normal(0.0, 1e-3, 3) * [1, 1, 0] for each in at]
    rows = [
        Measurement(motors=each.motors, position=place)
        for each, place in zip(at, places, strict=True)
    ]
    offset = "legs[0].motor.offset"
    found = calibrate(robot, rows, [YOUNG, offset], StandardDeviations(position=1e-3))
    assert found.undetermined == (f"{YOUNG} is not determined",)
    assert found.values[0] == robot.parameter_values([YOUNG])[0]
    assert found.doubts == ()
