# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The managed node: transitions from another process, with and without autostart."""

import re
from pathlib import Path

import numpy as np
import pytest
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveForward
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from helpers.driver import Driver, set_parameters
from helpers.node_process import Client, NodeProcess, change, free_domain
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import GetState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger


def state(client):
    return client.call(GetState, "/cpr_node/get_state", GetState.Request()).current_state.id


@pytest.fixture
def managed(tmp_path):
    domain = free_domain()
    arguments = ["-p", "robot:=rfrfr", "-p", "autostart:=false"]
    process = NodeProcess(tmp_path / "node.log", domain, arguments)
    client = Client(domain)
    try:
        yield process, client
    finally:
        client.close()
        assert process.stop() == 0, process.output()


def assert_not_ready(client):
    answer = client.call(SolveForward, "/cpr_node/solve_forward", SolveForward.Request())
    assert answer.error_code.val == ErrorCode.NOT_READY
    for kind, name, request in (
        (SetBool, "pause", SetBool.Request(data=True)),
        (Trigger, "reset", Trigger.Request()),
    ):
        answer = client.call(kind, f"/cpr_node/{name}", request)
        assert not answer.success
        assert "not active" in answer.message


def test_the_whole_life(managed):
    process, client = managed
    assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
    assert_not_ready(client)
    health = client.messages(DiagnosticArray, "/diagnostics", 1)[0].status
    assert [entry.level for entry in health] == [DiagnosticStatus.STALE]
    assert health[0].message == "unconfigured"
    assert set_parameters(client, "/cpr_node", max_speed=0.9).successful  # before there is a robot

    assert change(client, Transition.TRANSITION_CONFIGURE)
    assert state(client) == State.PRIMARY_STATE_INACTIVE
    # What takes long was done, and progress was told.
    for text in ("finding home", "at home after", "compiled inverse problem", "compiled shapes"):
        assert text in process.output()
    assert_not_ready(client)

    assert change(client, Transition.TRANSITION_ACTIVATE)
    assert state(client) == State.PRIMARY_STATE_ACTIVE
    drive = Driver(client)
    drive.send_motors(2.65, 0.5)
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.5]))
    entries = client.messages(DiagnosticArray, "/diagnostics", 1)[0].status
    assert {entry.name for entry in entries} == {"/cpr_node: node", "/cpr_node: stability"}
    assert entries[1].hardware_id == "rfrfr"
    assert entries[1].level == DiagnosticStatus.OK

    assert change(client, Transition.TRANSITION_DEACTIVATE)
    assert_not_ready(client)
    drive.forget()
    drive.send_motors(2.7, 0.5)
    drive.spin(0.3)
    assert not drive.all(StabilityMetrics)  # silent

    # Where the robot is stays known, what was sent meanwhile is not followed.
    assert change(client, Transition.TRANSITION_ACTIVATE)
    drive.until(lambda: drive.metrics.state == StabilityMetrics.STATE_IDLE)
    np.testing.assert_array_equal(drive.motors, [2.65, 0.5])

    assert change(client, Transition.TRANSITION_DEACTIVATE)
    assert change(client, Transition.TRANSITION_CLEANUP)
    assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
    assert change(client, Transition.TRANSITION_CONFIGURE)
    assert change(client, Transition.TRANSITION_ACTIVATE)
    # Forgotten is the robot, not where it is.
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.5]))

    # What was under way is not gone on with.
    drive.send_motors(3.6, 0.5)
    drive.until(lambda: drive.motors[0] > 2.7)
    assert change(client, Transition.TRANSITION_DEACTIVATE)
    drive.spin(0.1)
    drive.forget()
    assert change(client, Transition.TRANSITION_ACTIVATE)
    drive.spin(0.3)
    assert {told.state for told in drive.all(StabilityMetrics)} == {StabilityMetrics.STATE_IDLE}
    assert len({told.position[0] for told in drive.all(JointState)}) == 1
    assert drive.motors[0] < 3.0
    assert change(client, Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert state(client) == State.PRIMARY_STATE_FINALIZED


def test_an_impossible_transition_is_answered_with_no(managed):
    _, client = managed
    assert not change(client, Transition.TRANSITION_ACTIVATE)
    assert not change(client, 77)
    assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
    assert change(client, Transition.TRANSITION_CONFIGURE)
    assert not change(client, Transition.TRANSITION_CONFIGURE)
    assert change(client, Transition.TRANSITION_ACTIVATE)


def test_a_robot_that_cannot_be_loaded_leaves_a_managed_node_unconfigured(tmp_path):
    domain = free_domain()
    arguments = ["-p", "robot:=no_such_robot", "-p", "autostart:=false"]
    process = NodeProcess(tmp_path / "node.log", domain, arguments)
    client = Client(domain)
    try:
        assert not change(client, Transition.TRANSITION_CONFIGURE)
        assert state(client) == State.PRIMARY_STATE_UNCONFIGURED
        assert "no such file, nor a shipped robot" in process.output()
        assert_not_ready(client)
    finally:
        client.close()
        assert process.stop() == 0


def test_every_parameter_is_described_and_numbers_have_a_range(rfrfr):
    client = rfrfr.client
    listed = client.call(
        ListParameters, "/cpr_node/list_parameters", ListParameters.Request()
    ).result.names
    ours = [name for name in listed if "qos_overrides" not in name and name != "use_sim_time"]
    ours = [name for name in ours if not name.startswith("start_type_description")]
    described = client.call(
        DescribeParameters, "/cpr_node/describe_parameters", DescribeParameters.Request(names=ours)
    ).descriptors
    assert len(described) == len(ours) >= 28
    for descriptor in described:
        assert descriptor.description, descriptor.name
        if descriptor.type == ParameterType.PARAMETER_DOUBLE:
            assert descriptor.floating_point_range, descriptor.name
        if descriptor.type == ParameterType.PARAMETER_INTEGER:
            assert descriptor.integer_range, descriptor.name
    page = (Path(__file__).parents[3] / "docs/node.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (\w+) \| .* \| (live|read-only) \|", page, re.M)
    kinds = {
        ParameterType.PARAMETER_BOOL: "bool",
        ParameterType.PARAMETER_INTEGER: "integer",
        ParameterType.PARAMETER_DOUBLE: "double",
        ParameterType.PARAMETER_STRING: "string",
    }
    assert sorted(rows) == sorted(
        (
            descriptor.name,
            kinds[descriptor.type],
            "read-only" if descriptor.read_only else "live",
        )
        for descriptor in described
    )
    fixed = {descriptor.name for descriptor in described if descriptor.read_only}
    assert {"robot", "modes", "tick_rate", "motor_source", "autostart"} <= fixed
    assert "margin_stop" not in fixed
    refused = client.call(
        SetParameters,
        "/cpr_node/set_parameters",
        SetParameters.Request(
            parameters=[
                Parameter(
                    name="tick_rate",
                    value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=10.0),
                )
            ]
        ),
    ).results[0]
    assert not refused.successful
