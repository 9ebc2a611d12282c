# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where a node begins and what it remembers of it, by what it was told, had kept, and measures."""

from unittest.mock import Mock

import numpy as np
import pytest
from helpers.drive import robot
from helpers.session_bench import FIXED, Bench

from cpr_core import CprError, solve_forward, solve_home
from cpr_ros import whereabouts
from cpr_ros.operation.kept_state import KeptState
from cpr_ros.settings.node_settings import Parameters
from cpr_ros.whereabouts import Whereabouts

LAST, MEASURED = np.array([2.7, 0.4]), np.array([3.2, -0.1])


class Life:
    """A node that has just started, beside what one of before has left in its file.

    Attributes:
        measured: Where its motors are measured; None: nothing comes.
        publishers: How many publish that.
        agreeing: How far they may be apart.
    """

    def __init__(self, folder, monkeypatch):
        self.file, self.monkeypatch, self.measured = folder / "n.7.state", monkeypatch, None
        self.publishers, self.agreeing = 0, None
        self.node = Mock()
        self.leave(measured=False)

    def leave(self, measured):
        kept = KeptState(self.file, robot("rfrfr"))
        kept.keep(solve_forward(robot("rfrfr"), LAST), LAST, measured)
        kept.close()

    def damage(self):
        content = self.file.read_bytes()
        self.file.write_bytes(content[: len(content) // 2])

    def start(self, start_from):
        """Its whereabouts and its session."""
        self.monkeypatch.setattr(whereabouts, "other_publishers", lambda *_: self.publishers)
        self.monkeypatch.setattr(whereabouts, "first_measured", self._first_measured)
        self.monkeypatch.setattr(whereabouts, "_MEASURED_WAIT", 0.0)
        node = self.node
        node.get_fully_qualified_name.return_value = "/n"
        node.context.get_domain_id.return_value = 7
        session = Bench().session
        told = {"start_from": start_from, "state_directory": str(self.file.parent)}
        stop = Mock(wait_for=lambda work: work(), requested=False)
        return Whereabouts(node, Parameters(**FIXED | told), session, stop, -1e9), session

    def measure(self, motors):
        self.measured, self.publishers = motors, 1

    def _first_measured(self, node, robot, wait, stopped, agreeing):
        self.agreeing = agreeing
        return self.measured, "nothing came"

    def kept(self):
        """Where the motors are by the file, once its node has ended."""
        kept = KeptState(self.file, robot("rfrfr"))
        last = kept.last()
        kept.close()
        self.measured_before = last.measured
        return last.motors


@pytest.fixture
def life(tmp_path, monkeypatch):
    return Life(tmp_path, monkeypatch)


@pytest.mark.parametrize("measured", [True, False])
def test_that_nobody_measures_any_more_is_told(life, measured):
    life.leave(measured)
    where, session = life.start("auto")
    where.begin()
    where.look()
    said = [call.args[0] for call in life.node.get_logger().warning.call_args_list]
    told = "nothing publishes measured_joint_states now: it is taken to be where it was last"
    assert any(told in line for line in said) is measured
    np.testing.assert_array_equal(session.commands.newest, LAST)
    where.close()


def test_where_it_is_measured_is_remembered_before_the_first_tick(life):
    """Whoever is killed right after it was elsewhere last."""
    life.measure(MEASURED)
    place, session = life.start("auto")
    assert "where it was last" in place.begin()
    np.testing.assert_array_equal(session.commands.newest, LAST)
    place.look()
    np.testing.assert_array_equal(session.commands.newest, MEASURED)
    assert not session.unplaced
    assert life.agreeing == session.moved_by_others.tolerance > 0.0
    place.close()
    np.testing.assert_array_equal(life.kept(), MEASURED)
    assert life.measured_before


@pytest.mark.parametrize("start_from", ["auto", "measured"])
def test_over_a_damaged_file_it_has_to_be_measured_once(life, start_from):
    life.damage()
    place, _ = life.start(start_from)
    assert place.begin() == "where the robot is has to be measured"
    expected = "but no measured_joint_states" if start_from == "measured" else "has to be measured"
    with pytest.raises(CprError, match=expected) as refused:
        place.look()
    assert "start_from:=home" in str(refused.value)
    assert "start_from:=last" not in str(refused.value)
    place.place(LAST)
    if start_from == "auto":
        place.look()  # nobody measures any more: it stays where it was
    place.close()


def test_who_says_that_it_is_where_it_was_last_is_believed_against_measurements(life):
    life.measure(MEASURED)
    place, session = life.start("last")
    place.begin()
    place.look()
    np.testing.assert_array_equal(session.commands.newest, LAST)
    place.close()


def test_who_says_that_it_is_measured_is_told_that_it_may_be_where_it_was_last(life):
    place, _ = life.start("measured")
    place.begin()
    with pytest.raises(CprError, match=r"nothing came.* start_from:=last or start_from:=home"):
        place.look()
    place.close()


def test_who_says_that_it_is_where_it_was_last_is_told_that_this_is_not_known(life):
    life.damage()
    place, _ = life.start("last")
    with pytest.raises(CprError, match="the last state is not used"):
        place.begin()
    place.close()


@pytest.mark.parametrize("publishers", [0, 1])
def test_who_says_that_it_is_at_home_needs_neither_file_nor_measurement(life, publishers):
    life.damage()
    life.publishers = publishers
    place, session = life.start("home")
    assert place.begin().startswith("start_from is home")
    place.look()
    np.testing.assert_array_equal(
        session.solver.current.equilibrium.motors, solve_home(robot("rfrfr")).motors
    )
    place.close()


def test_home_is_gone_to_from_where_it_is_measured_once(life):
    home = solve_home(robot("rfrfr")).motors
    life.measure(MEASURED)
    place, session = life.start("home")
    place.begin()
    for measured, expected in ((place.look, home), (lambda: place.place(MEASURED), MEASURED)):
        measured()  # the second time it is where others have moved it
        np.testing.assert_allclose(session.solver.current.equilibrium.motors, expected, atol=1e-9)
        np.testing.assert_array_equal(session.commands.newest, MEASURED)
    place.look()  # activated again
    np.testing.assert_allclose(session.solver.current.equilibrium.motors, MEASURED, atol=1e-9)
    place.close()
