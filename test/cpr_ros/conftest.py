# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Nothing that a test starts is heard outside; a follower of each paper robot, without ROS; a node."""

from collections.abc import Iterator

import pytest
import rclpy
from helpers.drive import Drive, robot
from helpers.node_process import free_domain
from rclpy.context import Context
from rclpy.node import Node

from cpr_ros.process.own_domain import enter_own_domain

#: On this machine only.
_OWN_DOMAIN = enter_own_domain()


@pytest.fixture
def rfrfr() -> Drive:
    return Drive(robot("rfrfr"))


@pytest.fixture
def six_rfs() -> Drive:
    return Drive(robot("six_rfs"))


@pytest.fixture
def bare_node() -> Iterator[Node]:
    """A node of ROS in a domain of its own, with nothing of this project."""
    context = Context()
    rclpy.init(context=context, domain_id=free_domain())
    made = rclpy.create_node("bare", context=context)
    yield made
    made.destroy_node()
    rclpy.shutdown(context=context)
