# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Trackers of which little is known are begun with near where they are, and what is told is told."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers.simulated_measurements import equilibria, measured
from helpers.tracked_robots import (
    MARKER,
    TRACKER,
    as_told,
    noisy,
    random_frame,
    tracked,
    tracked_content,
)

import cpr_core
from cpr_core import (
    CalibrationWarning,
    StandardDeviations,
    calibrate,
    load_robot,
    propose_poses,
    read_measurements,
    solve_home,
    solve_inverse,
    write_poses,
)

FRAME = [0.4, -0.6, 1.8, 3.0, 0.3, -0.4]
FINE = StandardDeviations(position=1e-4, rotation=1e-3)


def off(found, truth):
    """How far values are from the truth, in standard deviations."""
    return np.abs(found.values - truth) / found.standard_deviations


def told_at(robot, places, seed=0, **options):
    """What the tracker of a robot tells at places, with noise."""
    return noisy(as_told(measured(places), robot, **options), FINE, seed)


def test_the_file_of_proposed_poses_is_calibrated_as_it_is(tmp_path):
    """Nothing was determined: natural units were sizes of what was described, and these are zeros."""
    robot, paths = tracked("six_rfs"), (*TRACKER, *MARKER)
    proposed = propose_poses(robot, paths, FINE, 6)
    write_poses(tmp_path / "poses.csv", proposed.equilibria)
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(robot, read_measurements(robot, tmp_path / "poses.csv"), paths, FINE)
    assert found.undetermined == ()
    assert found.values == pytest.approx(0.0, abs=1e-6)
    assert found.standard_deviations == pytest.approx(proposed.standard_deviations, rel=1e-3)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("described", [0.0, 1e-9, 1e-3, 0.3])
def test_what_was_described_before_does_not_matter(described):
    """A millimetre that was written for no place at all was the unit of what was to be found."""
    truth = [0.5, 0.3, 1.2, 0.01]
    paths = (*TRACKER[:3], "legs[0].motor.offset")
    robot = tracked("six_rfs", [described, 0.0, 0.0, 0.0, 0.0, 0.0])
    true_robot = robot.with_parameters(dict(zip(paths, truth, strict=True)))
    places = equilibria(true_robot, solve_home(robot), count=8)
    found = calibrate(robot, told_at(true_robot, places), paths, FINE)
    assert found.undetermined == ()
    assert off(found, truth).max() < 3.5


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["three_prs", "delta", "six_rus"])
@pytest.mark.parametrize("seed", [1, 3])
def test_platforms_that_hardly_move_or_hardly_turn_tell_it_too(name, seed):
    """Alternating between tracker and marker ended 2 rad off, or left the marker where it was."""
    generator = np.random.default_rng(seed)
    truth = [*random_frame(generator, 1.0), *random_frame(generator, 0.05)]
    robot, paths = tracked(name), (*TRACKER, *MARKER)
    true_robot = robot.with_parameters(dict(zip(paths, truth, strict=True)))
    home = solve_home(robot)
    reach = 0.1 * robot.motor_units.min()
    places = equilibria(true_robot, home, count=10, reach=reach, seed=seed)
    found = calibrate(robot, told_at(true_robot, places, seed), paths, FINE)
    assert found.fit < 1.5
    again = calibrate(true_robot, told_at(true_robot, places, seed), paths, FINE)
    assert found.fit == pytest.approx(again.fit, rel=1e-4)


@pytest.mark.parametrize("turned", [True, False])
def test_arms_that_are_longer_than_all_ways_are_no_other_unit(turned):
    """The platform turns in place, its marker is far out: millimetres were suspected."""
    robot, truth = tracked("six_rfs"), [*FRAME, 0.3, -0.2, 0.1, 0.2, 0.1, 0.3]
    paths = (*TRACKER, *MARKER) if turned else (*TRACKER, *MARKER[:3])
    true_robot = robot.with_parameters(dict(zip((*TRACKER, *MARKER), truth, strict=True)))
    home, generator = solve_home(true_robot), np.random.default_rng(2)
    places = []
    for _ in range(10):
        x, y, z, *_ = home.pose
        turn = generator.uniform(-0.15, 0.15, 3)
        quaternion = np.array([1.0, *(0.5 * turn)]) / np.linalg.norm([1.0, *(0.5 * turn)])
        way = generator.uniform(-1e-4, 1e-4, 3)
        places.append(solve_inverse(true_robot, [x + way[0], y + way[1], z + way[2], *quaternion]))
    found = calibrate(robot, told_at(true_robot, places, turned=turned), paths, FINE)
    assert found.fit < 1.5
    assert off(found, truth[: len(paths)]).max() < 4.0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [0.02, 1.0])
def test_a_tracker_far_from_a_small_robot_is_no_other_unit(size):
    """Places in its frame are a thousand times those in the world, in metres."""
    robot = tracked("six_rfs", [0.0, 0.0, 0.0, 3.0, 0.3, -0.4])
    far = [0.4 / size, 0.8 / size, 1.5 / size]
    true_robot = robot.with_parameters(dict(zip(TRACKER[:3], far, strict=True)))
    places = equilibria(true_robot, solve_home(robot), count=8)
    found = calibrate(robot, told_at(true_robot, places), TRACKER[:3], FINE)
    assert off(found, far).max() < 3.5


def test_what_only_together_is_determined_is_called_neither_product_nor_ratio():
    """A point does not turn: where its marker sits and where the camera is are one and the same."""
    robot, paths = tracked("rfrfr"), (*TRACKER, *MARKER[:3])
    true_robot = robot.with_parameters(dict(zip(paths, [*FRAME, 0.1, 0.02, 0.05], strict=True)))
    places = equilibria(true_robot, solve_home(robot), count=10)
    found = calibrate(robot, told_at(true_robot, places, turned=False), paths, FINE)
    assert len(found.undetermined) == 3
    for line, axis in zip(sorted(found.undetermined), range(3), strict=True):
        together = f"tracker.position[{axis}] by +1, tracker.marker.position[{axis}] by +1"
        assert line.endswith(together)
    assert np.isinf(found.standard_deviations[[0, 1, 2, 6, 7, 8]]).all()
    assert found.values[6:] == pytest.approx(0.0, abs=0.01)  # stays as it was


@pytest.mark.parametrize("far", [0.3, 1.0])
def test_one_row_that_is_grossly_wrong_is_left_aside_by_robust_losses(far):
    """Squares led away from where the alignment had been."""
    robot = tracked("six_rfs")
    paths = (*TRACKER, *MARKER, "legs[0].motor.offset", "legs[3].motor.offset")
    truth = [*FRAME, 0.02, -0.03, 0.04, 0.3, 1.1, -0.2, 0.01, -0.01]
    true_robot = robot.with_parameters(dict(zip(paths, truth, strict=True)))
    rows = told_at(true_robot, equilibria(true_robot, solve_home(robot)))
    rows[4] = replace(rows[4], position=rows[4].position + [far, 0.0, 0.0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        found = calibrate(robot, rows, paths, FINE, loss="cauchy")
    assert off(found, truth).max() < 4.0


@pytest.mark.filterwarnings("error")
def test_a_camera_straight_above_a_plane_tells_the_same_height_always():
    """Not a sensor that is stuck, though it should vary with the tilt that is described."""
    robot = tracked("rfrfr", [0.0, 0.5, 1.5, 3.12, 0.01, 0.0])
    true_robot = robot.with_parameters(dict(zip(TRACKER[3:], [np.pi, 0.0, 0.0], strict=True)))
    places = equilibria(true_robot, solve_home(robot), count=12)
    rows = [
        replace(row, position=np.round(row.position, 4))
        for row in as_told(measured(places), true_robot, turned=False)
    ]
    found = calibrate(robot, rows, TRACKER[3:], StandardDeviations(position=3e-5))
    assert found.values == pytest.approx([np.pi, 0.0, 0.0], abs=1e-3)


def test_a_bound_of_the_description_that_is_in_the_way_is_named():
    content = tracked_content("gough_stewart")
    content["legs"][0]["motor"]["limits"]["position"] = [0.001, 0.8]
    robot = load_robot(content)
    path = "legs[0].motor.offset"
    wide = tracked_content("gough_stewart")
    true_robot = load_robot(wide).with_parameters({path: -0.003})
    places = equilibria(true_robot, solve_home(load_robot(wide)), count=6, reach=0.03)
    with pytest.warns(CalibrationWarning, match=r"no robots: legs\[0\]\.motor\.limits\.position"):
        found = calibrate(robot, measured(places, deviations=FINE), [path], FINE)
    assert found.values[0] >= -0.001


def test_the_rotation_of_a_whole_turn_has_derivatives():
    """Differences led beyond it, and were called degrees."""
    robot = tracked("rfrfr", [0.1, 0.2, 1.5, 2.0 * np.pi, 0.0, 0.0])
    by = cpr_core.derivatives(solve_home(robot), TRACKER)
    assert not by.position.any()
    places = equilibria(robot, solve_home(robot), count=6)
    found = calibrate(robot, told_at(robot, places, turned=False), TRACKER, FINE)
    assert found.fit < 2.0


@pytest.mark.parametrize(
    ("path", "ends"),
    [
        (TRACKER[1], (-1.0, -0.65)),
        (TRACKER[1], (-0.5, 1.0)),
        (TRACKER[3], (2.0, 2.5)),
        (MARKER[2], (-0.01, 0.01)),
    ],
)
def test_within_bounds_the_others_make_up_for_what_they_can(path, ends):
    """One was put on its bound, the others were where they had fitted before, and stayed there."""
    robot, paths = tracked("six_rfs"), (*TRACKER, *MARKER)
    truth = [*FRAME, 0.02, -0.03, 0.04, 0.3, 1.1, -0.2]
    true_robot = robot.with_parameters(dict(zip(paths, truth, strict=True)))
    rows = told_at(true_robot, equilibria(true_robot, solve_home(robot), count=10))
    true_value = dict(zip(paths, truth, strict=True))[path]
    end = min(ends, key=lambda each: abs(each - true_value))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        found = calibrate(robot, rows, paths, FINE, bounds={path: ends})
        held = robot.with_parameters({path: end})
        others = tuple(each for each in paths if each != path)
        expected = calibrate(held, rows, others, FINE)
    freedom = sum(len(row.places) for row in found.rows) - np.array([len(paths), len(others)])
    sums = [found.fit**2 * freedom[0], expected.fit**2 * freedom[1]]
    assert sums[0] == pytest.approx(sums[1], rel=0.01)
    assert found.values[paths.index(path)] == pytest.approx(end, abs=1e-3 * (ends[1] - ends[0]))


def test_bounds_of_a_tracker_need_not_hold_what_is_described_and_are_in_order():
    robot, paths = tracked("six_rfs"), (*TRACKER, *MARKER)
    true_robot = robot.with_parameters(dict(zip(TRACKER, FRAME, strict=True)))
    rows = told_at(true_robot, equilibria(true_robot, solve_home(robot), count=8))
    found = calibrate(robot, rows, paths, FINE, bounds={TRACKER[2]: (1.0, 2.5)})
    assert off(found, [*FRAME, *[0.0] * 6]).max() < 4.0
    with pytest.raises(cpr_core.InvalidRequest, match="between"):
        calibrate(robot, rows, paths, FINE, bounds={TRACKER[2]: (2.5, 1.0)})


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(4))
def test_orientations_alone_tell_how_a_tracker_is_turned(seed):
    generator, robot = np.random.default_rng(seed), tracked("six_rfs")
    truth = [*random_frame(generator, 1.0)[3:], *random_frame(generator, 1.0)[3:]]
    paths = (*TRACKER[3:], *MARKER[3:])
    true_robot = robot.with_parameters(dict(zip(paths, truth, strict=True)))
    rows = told_at(true_robot, equilibria(true_robot, solve_home(robot), count=8))
    found = calibrate(robot, [replace(row, position=None) for row in rows], paths, FINE)
    assert found.fit < 1.5
    tracker, wanted = (each.description.tracker for each in (found.robot, true_robot))
    np.testing.assert_allclose(tracker.rotation, wanted.rotation, atol=0.02)
    np.testing.assert_allclose(tracker.marker_rotation, wanted.marker_rotation, atol=0.02)


def test_poses_are_written_as_far_as_they_will_be_measured(tmp_path):
    robot = tracked("six_rfs")
    home = solve_home(robot)
    for exact, written in (
        (StandardDeviations(position=1e-3), ["x", "y", "z"]),
        (StandardDeviations(rotation=1e-3), ["qw", "qx", "qy", "qz"]),
        (StandardDeviations(efforts=1e-3), []),
    ):
        write_poses(tmp_path / "poses.csv", [home], exact)
        header = (tmp_path / "poses.csv").read_text().splitlines()[0].split(",")
        assert [name for name in header if ":" in name] == [f"tracker:{name}" for name in written]
