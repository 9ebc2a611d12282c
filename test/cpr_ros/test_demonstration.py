# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the demonstration asks of its node and tells of the answers, without a node."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from cpr_msgs.msg import Equilibrium, ErrorCode
from cpr_msgs.srv import SolveForward

from cpr_core import CprError
from cpr_ros import demonstration
from cpr_ros.demonstration import Step

PAPER = Path(__file__).parents[1] / "data" / "6rfs_forward_path.csv"


class Called:
    """The service of a node that answers without solving, and what it was asked."""

    def __init__(self, monkeypatch):
        self.requests, self.offered, self.code = [], True, ErrorCode.SUCCESS
        self.client = SimpleNamespace(wait_for_service=lambda timeout_sec: self.offered)
        node = SimpleNamespace(create_client=lambda *_: self.client, destroy_node=lambda: None)
        ros = SimpleNamespace(init=lambda: None, try_shutdown=lambda: None)
        monkeypatch.setattr(demonstration, "rclpy", ros)
        monkeypatch.setattr(demonstration, "Node", lambda _: node)
        monkeypatch.setattr(demonstration, "_call", self.call)

    def call(self, _node, _client, request):
        self.requests.append(request)
        code = self.code if len(self.requests) > 3 else ErrorCode.SUCCESS
        return SolveForward.Response(error_code=ErrorCode(val=code, message="why"))


@pytest.fixture
def called(monkeypatch):
    return Called(monkeypatch)


def test_the_node_is_asked_along_the_path_of_the_paper(called):
    steps = demonstration._drive(SimpleNamespace(poll=lambda: None))
    assert [step.t for step in steps] == [*range(51)]
    lines = [line for line in PAPER.read_text().splitlines() if not line.startswith("#")]
    for row in csv.DictReader(lines):
        motors = called.requests[int(row["t"])].motors
        assert list(motors.name) == [f"motor{number}" for number in range(1, 7)]
        expected = [float(row[f"q{number}"]) for number in range(1, 7)]
        np.testing.assert_allclose(motors.position, expected, rtol=0.0, atol=1e-12)
    assert all(request.apply and request.with_eigenvalues for request in called.requests)


def test_an_answer_that_is_an_error_ends_it(called):
    called.code = ErrorCode.FAILURE
    with pytest.raises(CprError, match="t = 3: why"):
        demonstration._drive(SimpleNamespace(poll=lambda: None))


def test_a_node_that_does_not_come_ends_it(called, monkeypatch):
    called.offered = False
    monkeypatch.setattr(demonstration, "START_TIMEOUT", -1.0)
    with pytest.raises(CprError, match="ended with status 7"):
        demonstration._drive(SimpleNamespace(poll=lambda: 7, returncode=7))
    with pytest.raises(CprError, match="in time"):
        demonstration._drive(SimpleNamespace(poll=lambda: None))


def test_the_table_has_every_fifth_answer_and_the_medians_in_milliseconds():
    steps = []
    for t in range(51):
        solution = Equilibrium(smallest_eigenvalue_locked=0.25, solve_time=1e-3 * (t + 1))
        pose = solution.platform_in_base
        pose.position.x, pose.position.y, pose.position.z = 0.01 * t, 0.2, 0.3
        turn = pose.orientation
        turn.w, turn.x, turn.y, turn.z = 0.1, 0.5, 0.6, 0.7
        steps.append(Step(t, solution, 2e-3 * (t + 1)))
    *rows, medians = demonstration._table(steps).splitlines()[2:]
    assert [int(row.split()[0]) for row in rows] == [*range(0, 51, 5)]
    last = [float(word) for word in rows[-1].split()]
    assert last == [50, 0.5, 0.2, 0.3, 0.1, 0.5, 0.6, 0.7, 0.25, 51.0]
    assert medians == "medians of 51: solve 26.00 ms, request to answer 52.00 ms"
