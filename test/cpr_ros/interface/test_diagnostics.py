# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the node says of itself."""

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus

from cpr_ros.interface.diagnostics import NodeHealth, diagnostic_array

DROPPED = "messages dropped since the last diagnostics: 2 of a, 1 of b"
OTHERS = "/commands has 1 more publisher: others command the motors too"


@pytest.mark.parametrize(
    ("newest", "others", "words"),
    [
        ({}, "", []),
        ({"b": 1, "a": 2}, "", [DROPPED]),
        ({}, OTHERS, [OTHERS]),
        ({"b": 1, "a": 2}, OTHERS, [DROPPED, OTHERS]),
    ],
)
def test_what_is_wrong_is_told_in_one_line(newest, others, words):
    """Without a robot in operation the level is higher all the same."""
    health = NodeHealth("inactive", {"a": 7}, newest, late_ticks=3, commanders=others)
    (status,) = diagnostic_array("n", health, None, "", Time()).status
    assert status.message == "; ".join(["inactive", *words])
    assert status.level == DiagnosticStatus.STALE
    values = {value.key: value.value for value in status.values}
    assert values == {"life cycle": "inactive", "late ticks": "3", "dropped a": "7"}
