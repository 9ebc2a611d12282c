# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a tracker tells calibrates as poses in the world do, and says where the tracker is."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers.simulated_measurements import DEVIATIONS, PATHS, equilibria, measured, payload
from helpers.tracked_robots import MARKER, TRACKER, as_told, noisy, random_frame, tracked

import cpr_core
from cpr_core import (
    CalibrationWarning,
    InvalidRequest,
    Measurement,
    calibrate,
    propose_poses,
    read_measurements,
    write_poses,
)
from cpr_core.identification.compared import compared_row
from cpr_core.identification.measured_equilibria import followed

FRAME = [0.4, -0.6, 1.8, 3.0, 0.3, -0.4]
MARKED = [0.02, -0.03, 0.04, 0.3, 1.1, -0.2]
SOME = PATHS[:3]
SOFT = dict(zip(SOME, (200e9, 0.01, -0.02), strict=True))


@pytest.fixture(scope="module")
def known():
    """A robot of which the tracker is known."""
    return tracked("six_rfs", FRAME, MARKED)


@pytest.fixture(scope="module")
def places(known):
    """Where the true robot was, under a payload."""
    truth = known.with_parameters(SOFT)
    return equilibria(truth, cpr_core.solve_home(known), loads=payload(known))


@pytest.mark.filterwarnings("error")
def test_a_known_tracker_tells_as_much_as_the_world(known, places):
    world = measured(places, seed=3)
    found = [calibrate(known, rows, SOME, DEVIATIONS) for rows in (world, as_told(world, known))]
    # The platform's rotation moves the marker too: weights differ a little.
    assert found[1].values == pytest.approx(found[0].values, rel=0.02, abs=2e-3)
    assert found[1].fit == pytest.approx(found[0].fit, rel=0.02)
    off = (found[1].values - list(SOFT.values())) / found[1].standard_deviations
    assert np.abs(off).max() < 3.0


def test_what_is_exact_is_found_wherever_the_tracker_is(places):
    """Nobody has said where: the description has it at the origin."""
    paths = (*TRACKER, *MARKER, *SOME)
    for seed in range(2):
        generator = np.random.default_rng(seed)
        frames = random_frame(generator, 2.0), random_frame(generator, 0.05)
        rows = as_told(measured(places[:10]), tracked("six_rfs", *frames))
        with pytest.warns(CalibrationWarning, match="may be too large"):
            found = calibrate(tracked(), rows, paths, DEVIATIONS)
        tracker, wanted = found.robot.description.tracker, tracked("six_rfs", *frames)
        wanted = wanted.description.tracker
        for name in ("position", "rotation", "marker_position", "marker_rotation"):
            assert getattr(tracker, name) == pytest.approx(getattr(wanted, name), abs=1e-7), name
        assert found.values[12:] == pytest.approx(list(SOFT.values()), rel=1e-6, abs=1e-6)
        assert found.start[:12].tolist() == [0.0] * 12
        assert found.undetermined == ()


def test_intervals_hold_the_truth(known, places):
    """Tracker, marker and robot together: normal numbers of unit variance, within what chance allows."""
    paths = (*TRACKER, *MARKER, *SOME)
    truth = np.array([*FRAME, *MARKED, *SOFT.values()])
    off = []
    for seed in range(4):
        rows = as_told(measured(places), known)
        found = calibrate(tracked(), noisy(rows, DEVIATIONS, seed), paths, DEVIATIONS)
        off.append((found.values - truth) / found.standard_deviations)
    assert 0.75 < np.sqrt(np.mean(np.square(off))) < 1.3
    assert np.abs(off).max() < 4.0


def test_a_tracker_that_is_to_be_found_by_rows_in_the_world_is_told(known, places):
    """Twelve lines said that its numbers are not determined, and none why."""
    rows, paths = measured(places, seed=3), (*TRACKER, *MARKER)
    with pytest.warns(CalibrationWarning, match=r"^no row is in the tracker's frame, .* tracker:x"):
        found = calibrate(tracked(), rows, (*paths, *SOME), DEVIATIONS)
    assert len(found.undetermined) == len(paths) and len(found.doubts) == 1
    mixed = [*rows[1:], *as_told(rows[:1], known)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        assert not any(
            "frame" in doubt for doubt in calibrate(known, mixed, paths, DEVIATIONS).doubts
        )
        assert not any(
            "frame" in doubt for doubt in calibrate(known, rows, SOME, DEVIATIONS).doubts
        )


@pytest.mark.filterwarnings("error")
def test_positions_alone_tell_where_a_camera_above_the_plane_is():
    """A ball on the platform: how it is turned on it is not to be found."""
    frame = [0.1, 0.7, 1.5, 3.0, 0.2, 0.1]
    robot = tracked("rfrfr", frame)
    places = equilibria(robot, cpr_core.solve_home(robot), count=10)
    rows = as_told(measured(places, seed=1), robot, turned=False)
    found = calibrate(tracked("rfrfr"), rows, TRACKER, DEVIATIONS)
    off = (found.values - frame) / found.standard_deviations
    assert np.abs(off).max() < 3.5
    assert found.undetermined == ()


@pytest.mark.parametrize("paths", [(*SOME, *TRACKER, *MARKER), (*TRACKER[:2], *MARKER[4:])])
def test_derivatives_are_differences(known, places, paths):
    """Of residuals by all parameters, with noise in the motors that drive the rows."""
    deviations = replace(DEVIATIONS, motors=1e-3)
    for row, place in zip(as_told(measured(places[:2], seed=4), known), places[:2], strict=True):
        start = cpr_core.continued(place, known)
        compared = compared_row(row, start, deviations)
        rates = compared.rates(start, paths)
        for column, path in enumerate(paths):
            (value,) = known.parameter_values(path)
            step = 1e-5 * max(1.0, abs(value))
            ends = []
            for sign in (-1.0, 1.0):
                (end,) = followed(
                    [start], known.with_parameters({path: value + sign * step}), ["motors"]
                )
                ends.append(compared.residual(end))
            differs = (ends[1] - ends[0]) / (2.0 * step)
            size = np.abs(differs).max()
            assert rates[:, column] == pytest.approx(differs, abs=1e-6 * size, rel=1e-5), path


def test_noise_of_motors_is_carried_to_what_a_tracker_tells(places):
    """Axes that are turned change no sum of squares: the marker is at the platform origin here."""
    robot, deviations = tracked("six_rfs", FRAME), replace(DEVIATIONS, motors=5e-3)
    for row, place in zip(measured(places[:3], seed=6), places, strict=False):
        start = cpr_core.continued(place, robot)
        (told,) = as_told([row], robot)
        sums = []
        for each in (row, told):
            residual = compared_row(each, start, deviations).residual(start)
            sums.append(residual @ residual)
        assert sums[1] == pytest.approx(sums[0], rel=1e-9)


def test_proposed_poses_know_the_tracker(known, places, tmp_path):
    """Their deviations are those of a calibration, and the file has what it will tell."""
    paths = (*TRACKER, "legs[0].motor.offset")
    proposed = propose_poses(known, paths, DEVIATIONS, 8)
    write_poses(tmp_path / "poses.csv", proposed.equilibria)
    header = (tmp_path / "poses.csv").read_text().splitlines()[0].split(",")
    assert [name for name in header if ":" in name] == [
        f"tracker:{name}" for name in ("x", "y", "z", "qw", "qx", "qy", "qz")
    ]
    rows = read_measurements(known, tmp_path / "poses.csv")
    for row, each in zip(rows, proposed.equilibria, strict=True):
        position, rotation = known.description.tracker.marker_in_tracker(
            each.platform_position, each.platform_rotation
        )
        assert row.frame == "tracker"
        assert row.position == pytest.approx(position, abs=1e-8)
        assert row.rotation == pytest.approx(rotation, abs=1e-8)
    with pytest.warns(CalibrationWarning, match="may be too large"):
        found = calibrate(known, rows, paths, DEVIATIONS)
    assert proposed.standard_deviations == pytest.approx(found.standard_deviations, rel=0.01)


def test_a_tracker_that_is_stuck_and_another_order_of_numbers_are_seen(known, places):
    rows = as_told(measured(places, seed=5), known)
    stuck = [replace(row, position=[*rows[0].position[:2], row.position[2]]) for row in rows]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        doubts = calibrate(known, stuck, SOME, DEVIATIONS).doubts
    assert [doubt.partition(" is ")[0] for doubt in doubts[:2]] == ["position x", "position y"]
    swapped = [replace(row, quaternion_wxyz=np.roll(row.quaternion_wxyz, -1)) for row in rows]
    with pytest.raises(InvalidRequest, match="looks like x y z w"):
        calibrate(known, swapped, SOME, DEVIATIONS)


def test_millimetres_of_a_tracker_are_refused_wherever_it_is(known, places):
    rows = as_told(measured(places), known)
    wrong = [replace(row, position=1e3 * row.position) for row in rows]
    with pytest.raises(InvalidRequest, match="another unit"):
        calibrate(known, wrong, SOME, DEVIATIONS)
    with pytest.raises(
        InvalidRequest, match=r"tracker's frame are 1\.\d+e\+03 times .* expected m"
    ):
        calibrate(tracked(), wrong, (*TRACKER, *SOME), DEVIATIONS)


def test_rows_in_a_line_do_not_say_where_a_tracker_is(known):
    """Nothing is turned by chance: what is described is begun with."""
    home = cpr_core.solve_home(known)
    rows = as_told(measured([home, home, home]), known, turned=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CalibrationWarning)
        found = calibrate(known, rows, TRACKER, DEVIATIONS)
    assert found.values == pytest.approx(FRAME, abs=1e-9)
    assert found.undetermined


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"frame": "camera"}, "expected world or tracker, got 'camera'"),
        ({"motors": None}, "a pose in the tracker's frame drives none"),
    ],
)
def test_rows_that_are_none_are_refused(known, places, change, text):
    (row,) = as_told(measured(places[:1]), known)
    with pytest.raises(InvalidRequest, match=text):
        calibrate(known, [replace(row, **change)], SOME[:1], DEVIATIONS)


def test_a_robot_without_a_tracker_has_nothing_told(places):
    robot = cpr_core.load_robot("six_rfs")
    row = Measurement(motors=places[0].motors, position=[0, 0, 0.3], frame="tracker", label="row 7")
    with pytest.raises(InvalidRequest, match=r"row 7: frame: .* of six_rfs has no tracker"):
        calibrate(robot, [row], SOME[:1], DEVIATIONS)


@pytest.mark.parametrize(
    ("robot", "header", "text"),
    [
        (tracked("rfrfr"), "motor1,motor2,tracker:x,y", "poses in one frame, got tracker:x and y"),
        (tracked("rfrfr"), "motor1,motor2,tracker:w", "did you mean tracker:qw"),
        ("rfrfr", "motor1,motor2,tracker:x", "no column is called 'tracker:x'"),
    ],
)
def test_columns_are_of_one_frame_that_the_robot_has(robot, header, text, tmp_path):
    robot = cpr_core.load_robot(robot) if isinstance(robot, str) else robot
    file = tmp_path / "data.csv"
    file.write_text(f"{header}\n" + ",".join("0" * len(header.split(","))) + "\n")
    with pytest.raises(InvalidRequest, match=text):
        read_measurements(robot, file)


@pytest.mark.parametrize("angle", [3.1, -3.1])
def test_a_turn_is_told_as_it_was_described_and_within_bounds(known, places, angle):
    """A camera that looks straight down: just beyond half a turn is not the other way round."""
    frame = [0.4, -0.6, 1.8, np.copysign(3.2, angle), 0.0, 0.0]
    rows = as_told(measured(places[:8]), tracked("six_rfs", frame))
    described = tracked("six_rfs", [0.3, -0.5, 1.9, angle, 0.0, 0.0])
    bounds = {TRACKER[3]: sorted([0.9 * angle, 1.1 * angle]), TRACKER[0]: [0.2, 0.38]}
    for limits, values in ((None, frame), (bounds, [0.38, *frame[1:]])):
        with pytest.warns(CalibrationWarning):
            found = calibrate(described, rows, (*TRACKER, *SOME), DEVIATIONS, bounds=limits)
        assert found.values[:6] == pytest.approx(values, abs=0.1 if limits else 1e-6)
        assert found.values[0] <= 0.38 + 0.1 * (limits is None)
