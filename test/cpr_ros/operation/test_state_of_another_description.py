# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A last state of another robot or description: commands stay known, the equilibrium does not."""

import numpy as np
import pytest
import yaml
from helpers.kept_states import HEADER, ROBOT, at
from helpers.tracked_robots import tracked
from helpers.yaml_content import shipped_content

from cpr_core import load_robot, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_ros.operation.kept_state import KeptState


def test_another_robot_or_description_is_told(file):
    KeptState(file, ROBOT).close()
    content = shipped_content("rfrfr")
    content["rod"]["length"] *= 1.01
    for other in (load_robot("rfrfr", modes=6), load_robot(yaml.safe_dump(content))):
        kept = KeptState(file, ROBOT)
        kept.keep(at(0.5), at(0.5).motors)
        kept.close()
        kept = KeptState(file, other)
        assert "another description" in kept.problem
        assert kept.last() is None
        kept.close()


def renamed(name, old="rfrfr", new="other"):
    content = shipped_content(name)
    content["name"] = new
    return load_robot(yaml.safe_dump(content))


def test_motors_stand_where_they_were_sent_whatever_is_said_of_their_robot(file):
    """A calibration moved them home with the next command, one radian at once."""
    calibrated = ROBOT.with_parameters({"rod.density": 7801.0})
    for other in (calibrated, load_robot("rfrfr", modes=6), load_robot("rfrfr", modes=3)):
        kept = KeptState(file, ROBOT)
        for fraction in (0.2, 0.5):
            kept.keep(at(fraction), at(fraction).motors + 0.01)
        assert kept.commands_before is None
        kept.close()
        kept = KeptState(file, other)
        np.testing.assert_array_equal(kept.commands_before, at(0.5).motors + 0.01)
        np.testing.assert_array_equal(kept.last_commands(), at(0.5).motors + 0.01)
        home = solve_home(other)
        kept.keep(home, home.motors)
        assert kept.commands_before is None
        np.testing.assert_array_equal(kept.last_commands(), home.motors)
        kept.close()


def test_motors_that_were_lost_are_lost_for_another_description_too(file):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), None)
    kept.close()
    kept = KeptState(file, load_robot("rfrfr", modes=6))
    assert np.isnan(kept.commands_before).all()
    assert kept.last_commands() is None
    kept.close()


def test_a_robot_that_never_moved_leaves_no_commands_to_another_description(file):
    """Else its motors would be led from 0, where a new file has them, to home."""
    KeptState(file, ROBOT).close()
    kept = KeptState(file, load_robot("rfrfr", modes=6))
    assert kept.commands_before is None and kept.last_commands() is None
    kept.close()


@pytest.mark.parametrize(
    "other", [lambda: renamed("rfrfr"), lambda: renamed("three_rfs", new="rfrfr")]
)
def test_motors_of_another_robot_tell_nothing(file, other):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    kept = KeptState(file, other())
    assert "another robot" in kept.problem
    assert kept.commands_before is None and kept.last_commands() is None
    kept.close()


@pytest.mark.parametrize("length", [0, 1, 8])
def test_a_cut_file_of_another_description_tells_nothing(file, length):
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    file.write_bytes(file.read_bytes()[: HEADER + length])
    kept = KeptState(file, load_robot("rfrfr", modes=6))
    assert kept.commands_before is None and kept.last_commands() is None
    kept.close()


def test_a_comment_is_no_other_description(file):
    """Commands jumped home after somebody had noted something in the file."""
    text = shipped_robots()["rfrfr"].read_text()
    kept = KeptState(file, ROBOT)
    kept.keep(at(0.5), at(0.5).motors)
    kept.close()
    for same in (text + "# edited\n", "# edited\n" + text, text.replace(", ", ",   ")):
        assert same != text
        kept = KeptState(file, load_robot(same))
        assert not kept.problem
        np.testing.assert_array_equal(kept.last().motors, at(0.5).motors)
        kept.close()


def test_what_another_description_left_stays_until_something_new_is_kept(file):
    """One start with the wrong parameters must not cost the last state."""
    kept = KeptState(file, ROBOT)
    for fraction in (0.3, 0.6):
        kept.keep(at(fraction), at(fraction).motors)
    kept.close()
    # A description of the same size, so that old slots would pass for new.
    same_size = ROBOT.with_parameters({"rod.density": 7801.0})
    others = (load_robot("rfrfr", modes=6), same_size, load_robot("rfrfr", modes=3))
    for other in others:
        kept = KeptState(file, other)
        assert "another description" in kept.problem
        assert kept.last() is None
        kept.close()
    kept = KeptState(file, ROBOT)
    assert not kept.problem
    np.testing.assert_array_equal(kept.last().motors, at(0.6).motors)
    kept.close()
    for other in others:
        kept = KeptState(file, other)
        home = solve_home(other)
        kept.keep(home, home.motors + 0.01)
        kept.close()
        kept = KeptState(file, other)
        np.testing.assert_array_equal(kept.last().motors, home.motors + 0.01)
        kept.close()
        kept = KeptState(file, ROBOT)  # the robot has been elsewhere since
        assert "another description" in kept.problem
        assert kept.last() is None
        kept.close()


def test_where_a_tracker_is_does_not_matter_and_all_else_does(file):
    """A camera that was calibrated is no other robot: its motors stand where they stood."""
    robots = [
        tracked("rfrfr"),
        tracked("rfrfr", [0.1, 0.2, 1.5, np.pi, 0.0, 0.0], [0.0, 0.0, 0.01, 0.0, 0.0, 0.0]),
        tracked("rfrfr").with_parameters({"rod.young_modulus": 200e9}),
    ]
    for robot, known in zip(robots, (False, True, False), strict=True):
        kept = KeptState(file, robot)
        assert (kept.last() is not None) is known
        assert bool(kept.problem) is (robot is robots[2])
        if robot is robots[0]:
            home = solve_home(robot)
            kept.keep(home, home.motors + 0.01)
        kept.close()
