# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node publishes, seen from another process."""

from itertools import pairwise

import numpy as np
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import SolveInverse
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParametersAtomically
from sensor_msgs.msg import JointState


def stamp(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def go_to(running, x, y):
    target = PoseStamped()
    target.pose.position.x, target.pose.position.y = float(x), float(y)
    answer = running.client.call(
        SolveInverse,
        "/cpr_node/solve_inverse",
        SolveInverse.Request(platform=target, apply=True),
    )
    assert answer.error_code.val == ErrorCode.SUCCESS, answer.error_code.message


def set_thresholds(running, **values):
    parameters = [
        Parameter(
            name=name,
            value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value),
        )
        for name, value in values.items()
    ]
    return running.client.call(
        SetParametersAtomically,
        "/cpr_node/set_parameters_atomically",
        SetParametersAtomically.Request(parameters=parameters),
    ).result


def next_stability(running):
    return running.client.messages(StabilityMetrics, "/cpr_node/stability", 2)[-1]


def test_joint_states_carry_names_positions_and_efforts(six_rfs):
    state = six_rfs.client.messages(JointState, "/joint_states", 1)[0]
    assert list(state.name) == [f"motor{k}" for k in range(1, 7)]
    np.testing.assert_allclose(state.position, [5.86, 5.56, 5.86, 5.46, 5.86, 5.26])
    np.testing.assert_allclose(
        state.effort,
        [0.6904490, 0.4845962, 0.7214631, 0.4451453, 0.7671520, 0.3596534],
        atol=2e-4,
    )
    assert state.header.frame_id == "base"
    assert len(state.velocity) == 6


def test_platform_pose_is_the_home_of_the_paper(six_rfs):
    pose = six_rfs.client.messages(PoseStamped, "/cpr_node/platform_pose", 1)[0]
    point = pose.pose.position
    np.testing.assert_allclose(
        [point.x, point.y, point.z], [0.0364845, 0.0132957, 0.8453250], atol=2e-5
    )
    assert pose.header.frame_id == "base"


def test_state_and_stability_keep_coming_with_rising_stamps(six_rfs):
    for kind, topic in (
        (JointState, "/joint_states"),
        (StabilityMetrics, "/cpr_node/stability"),
    ):
        stamps = [stamp(message) for message in six_rfs.client.messages(kind, topic, 10)]
        assert all(later > earlier for earlier, later in pairwise(stamps))


def test_stability_at_home_is_stable_and_asks_for_nothing(six_rfs):
    metrics = next_stability(six_rfs)
    assert metrics.status == StabilityMetrics.STATUS_NO_WARNING
    assert metrics.action == StabilityMetrics.ACTION_NONE
    assert metrics.speed_scale == 1.0
    assert metrics.converged and metrics.energy_criterion_applies
    assert (metrics.index_locked, metrics.index_free) == (0, 0)
    assert 0.8 < metrics.margin < 0.9
    assert list(metrics.smallest_eigenvalues_locked) == sorted(metrics.smallest_eigenvalues_locked)
    assert metrics.smallest_eigenvalues_locked[0] > 0.0
    assert 0.0 < metrics.inverse_condition_number < 1.0
    assert metrics.solve_time > 0.0


def test_stability_asks_to_slow_down_and_to_halt_towards_the_crossing(rfrfr):
    # The locked crossing lies at y = 0.03571 (5 modes: close by).
    seen = []
    for y in (0.8, 0.1, 0.04):
        go_to(rfrfr, 0.0, y)
        metrics = next_stability(rfrfr)
        assert metrics.index_locked == 0
        seen.append((metrics.action, metrics.speed_scale, metrics.margin))
    go_to(rfrfr, 0.0, 0.8)
    actions, scales, margins = zip(*seen, strict=True)
    assert actions == (
        StabilityMetrics.ACTION_NONE,
        StabilityMetrics.ACTION_SLOW,
        StabilityMetrics.ACTION_HALT,
    )
    assert scales[0] == 1.0 > scales[1] > scales[2] == 0.0
    assert margins[0] > margins[1] > margins[2] > 0.0


def test_thresholds_change_live_and_inconsistent_ones_are_refused(rfrfr):
    assert set_thresholds(rfrfr, margin_warning=0.99, margin_stop=0.98).successful
    metrics = next_stability(rfrfr)
    assert (metrics.margin_warning, metrics.margin_stop) == (0.99, 0.98)
    assert metrics.action == StabilityMetrics.ACTION_HALT
    refused = set_thresholds(rfrfr, margin_warning=0.1, margin_stop=0.3)
    assert not refused.successful
    assert "below margin_warning" in refused.reason
    assert next_stability(rfrfr).margin_warning == 0.99
    assert set_thresholds(rfrfr, margin_warning=0.2, margin_stop=0.05).successful
    assert next_stability(rfrfr).action == StabilityMetrics.ACTION_NONE
