# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The process of a map ends with the node, however that ends."""

import signal

import pytest
from action_msgs.msg import GoalStatus
from cpr_msgs.msg import ErrorCode
from helpers.driver import Driver
from helpers.map_client import MEDIUM, MapClient, lives, workers_of
from helpers.node_process import Client, NodeProcess, change, free_domain
from lifecycle_msgs.msg import Transition

import cpr_core
from cpr_core.workspace.store import read_map


@pytest.fixture
def mapping(tmp_path):
    """A node that makes a map: its process, a client, the goal, the process of the map."""
    domain = free_domain()
    process = NodeProcess(
        tmp_path / "node.log", domain, ["-p", "robot:=rfrfr", "-p", "map_anywhere:=true"]
    )
    client = Client(domain)
    try:
        process.wait_for_log("ready")
        maps = MapClient(client)
        handle = maps.send(tmp_path / "map.nc", MEDIUM, workers=1)
        maps.until_done(100)
        (worker,) = workers_of(process.process.pid)
        yield process, maps, handle, worker
    finally:
        client.close()
        process.stop(signal.SIGKILL)


def assert_kept(folder):
    """What was found is in the file, and nothing else is left behind."""
    assert {file.name for file in folder.iterdir()} == {"node.log", "map.nc"}
    found = read_map(folder / "map.nc", cpr_core.load_robot("rfrfr"))
    assert 100 <= found.expanded < found.reached.sum()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_the_map_ends_with_the_node(mapping, tmp_path, how):
    process, maps, _, worker = mapping
    status = process.stop(how)
    assert status == (-signal.SIGKILL if how == signal.SIGKILL else 0), process.output()
    maps.client.spin_until(lambda: not lives(worker))
    assert "Traceback" not in process.output()
    assert_kept(tmp_path)


def test_cleaning_up_ends_the_map_deactivating_does_not(mapping, tmp_path):
    process, maps, handle, worker = mapping
    assert change(maps.client, Transition.TRANSITION_DEACTIVATE)
    maps.until_done(maps.feedback[-1].done + 1)
    assert change(maps.client, Transition.TRANSITION_CLEANUP)
    status, result = maps.result(handle)
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code.val == ErrorCode.NOT_READY
    assert "cleaned up" in result.error_code.message
    assert not lives(worker)
    assert_kept(tmp_path)

    status, result = maps.make(tmp_path / "other.nc")
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code.val == ErrorCode.NOT_READY
    assert change(maps.client, Transition.TRANSITION_CONFIGURE)
    assert change(maps.client, Transition.TRANSITION_ACTIVATE)
    Driver(maps.client).close()
    assert maps.make(tmp_path / "other.nc")[0] == GoalStatus.STATUS_SUCCEEDED
    assert process.stop() == 0
