# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The examples against a real node."""

import os
import re
import signal
import subprocess
import sys
import time
from xml.etree import ElementTree

import numpy as np
import pytest
from cpr_msgs.action import MapWorkspace
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import WrenchStamped
from helpers.example_process import EXAMPLES, started_example
from helpers.node_process import TIMEOUT, Client, free_domain, running_node
from rclpy.action import ActionServer
from std_srvs.srv import SetBool

from cpr_ros.interface.streams import promised

pytestmark = pytest.mark.waits(seconds=60)


def test_the_supervisor_sends_a_halted_robot_home(rfrfr, drive):
    supervisor = started_example(rfrfr.client, "supervisor.py")
    try:
        drive.client.spin_until(
            lambda: drive.client.node.count_subscribers("/cpr_node/stability") >= 2
        )
        drive.send_platform(0.0, -0.2)
        drive.until_state(StabilityMetrics.STATE_HALTED)
        drive.until(lambda: np.array_equal(drive.motors, [2.59, 0.55]), timeout=TIMEOUT)
        drive.until_state(StabilityMetrics.STATE_IDLE)
    finally:
        supervisor.send_signal(signal.SIGINT)
        said, _ = supervisor.communicate(timeout=TIMEOUT)
    assert supervisor.returncode == 0, said
    assert "HALT: the next margin" in said
    assert "reset: True" in said


def test_the_supervisor_acts_on_a_halt_in_any_state(rfrfr, drive, tmp_path):
    """A wrench that is not borne halts a robot at rest; its state is IDLE."""
    log = tmp_path / "supervisor.log"
    with log.open("w") as output:
        supervisor = started_example(rfrfr.client, "supervisor.py", stdout=output)
    pushed = WrenchStamped()
    pushed.wrench.force.y = -1000.0
    # No wrench is old while this process, which measures, is held up.
    assert drive.set_parameters(wrench_timeout=600.0).successful
    pushing = drive.client.node.create_timer(0.05, lambda: drive.wrench.publish(pushed))
    try:
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_HALT)
        assert drive.metrics.state == StabilityMetrics.STATE_IDLE
        drive.client.spin_until(lambda: "reset: True" in log.read_text())
        assert "HALT: the external wrench is not borne" in log.read_text()
        drive.client.node.destroy_timer(pushing)
        assert drive.set_parameters(wrench_timeout=0.5).successful
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_SLOW)
        assert "older than wrench_timeout" in drive.metrics.status_text  # as if the sensor had died
        assert drive.set_parameters(wrench_timeout=600.0).successful
        drive.wrench.publish(WrenchStamped())
        drive.until(lambda: drive.metrics.action == StabilityMetrics.ACTION_NONE)
        drive.client.spin_until(lambda: "NONE: stable" in log.read_text())
    finally:
        drive.client.node.destroy_timer(pushing)
        assert drive.set_parameters(wrench_timeout=0.5).successful
        supervisor.send_signal(signal.SIGINT)
        assert supervisor.wait(TIMEOUT) == 0
    assert log.read_text().count("halted for too long") == 1


@pytest.mark.parametrize("step", [0, 10], ids=["paused", "jumping"])
def test_the_patience_of_the_supervisor_does_not_go_by_stamps(step):
    """Where the time of ROS stood still it waited for ever, where it jumped not at all."""
    client, calls, sent = Client(free_domain()), [], []
    stream = client.node.create_publisher(StabilityMetrics, "cpr_node/stability", promised(20.0))

    def paused(request, response):
        calls.append((time.monotonic(), request.data))
        response.success = True
        return response

    def halt():
        sent.append(time.monotonic())
        message = StabilityMetrics(action=StabilityMetrics.ACTION_HALT)
        message.header.stamp.sec = step * len(sent)
        stream.publish(message)

    client.node.create_service(SetBool, "cpr_node/pause", paused)
    supervisor = started_example(client, "supervisor.py")
    try:
        client.spin_until(lambda: stream.get_subscription_count() > 0)
        client.node.create_timer(0.05, halt)
        client.spin_until(lambda: calls)
        assert calls[0][1]
        assert calls[0][0] - sent[0] > 2.0  # PATIENCE
    finally:
        supervisor.send_signal(signal.SIGINT)
        said, _ = supervisor.communicate(timeout=TIMEOUT)
        client.close()
    assert "halted for too long" in said


#: What is in programs of the page that tests of the closed loop, trajectories and signs of life run.
OF_OTHERS = ("liveliness", "measured_platform_pose", "platform_twist", "FollowTrajectory")


def test_the_programs_of_the_page_about_the_node_do_what_they_say(rfrfr, drive, tmp_path):
    """But for those that need somebody beside the node, or move it on: other tests run them."""
    page = (EXAMPLES.parent / "docs/node.md").read_text(encoding="utf-8")
    programs = [
        block
        for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        if not any(word in block for word in OF_OTHERS)
    ]
    assert len(programs) >= 3
    for number, program in enumerate(programs):
        file = tmp_path / f"program{number}.py"
        file.write_text(program)
        done = started_example(rfrfr.client, file, cwd=tmp_path)
        drive.client.spin_until(lambda done=done: done.poll() is not None, timeout=60.0)
        said = done.stdout.read()
        assert done.returncode == 0, said
        assert said.strip()
        assert "message=''" in said or "error_code" not in program, said  # no failure
    assert ElementTree.parse(tmp_path / "robot.urdf").getroot().tag == "robot"
    drive.until(lambda: drive.motors[0] == 2.59 + 0.1)


def test_a_map_is_made_cancelled_and_gone_on_with(rfrfr, tmp_path):
    file = tmp_path / "map.nc"
    command = ("map.py", str(file), "x=-0.9:0.9", "y=-1:1", "--resolution", "0.01")
    cancelled = started_example(rfrfr.client, *command)
    said = ""
    while "/s" not in said:  # feedback on one line, or the end
        read = cancelled.stdout.read(1)
        assert read, said
        said += read
    cancelled.send_signal(signal.SIGINT)
    rest, _ = cancelled.communicate(timeout=60)
    assert cancelled.returncode == 1, said + rest
    assert "-7: the map was cancelled" in rest
    whole = started_example(rfrfr.client, *command)
    said, _ = whole.communicate(timeout=120)
    assert whole.returncode == 0, said
    assert f"{file}: 23450 of 36381 cells are reached" in said
    assert "border stability:" in said


def test_a_map_whose_node_is_gone_is_not_waited_for():
    client = Client(free_domain())
    goals = []
    server = ActionServer(
        client.node,
        MapWorkspace,
        "cpr_node/map_workspace",
        execute_callback=lambda goal: MapWorkspace.Result(),
        handle_accepted_callback=goals.append,  # and never executed
    )
    try:
        asking = started_example(client, "map.py", "map.nc", "x=-0.9:0.9", "y=-1:1")
        client.spin_until(lambda: len(goals) == 1 and asking.poll() is None)
        server.destroy()
        client.spin_until(lambda: asking.poll() is not None)
        assert "cpr_node is gone" in asking.stdout.read()
        assert asking.returncode == 1
    finally:
        asking.kill()
        client.close()


def test_the_circle_says_when_nobody_is_there():
    """A domain of its own, without a node."""
    done = subprocess.run(
        [sys.executable, EXAMPLES / "circle.py"],
        env=os.environ | {"ROS_DOMAIN_ID": str(free_domain())},
        capture_output=True,
        text=True,
        timeout=90,
    )
    assert done.returncode == 1
    assert "no cpr_node" in done.stderr


def test_the_circle_is_driven_in_simulated_time(tmp_path):
    """Its clock was compared with stamps of another time, here 0, and no pose came late enough."""
    with running_node(tmp_path, "robot:=rfrfr", "use_sim_time:=true") as running:
        circle = started_example(running.client, "circle.py", "--radius", "0.01", "--period", "0.5")
        running.client.spin_until(lambda: circle.poll() is not None, timeout=60.0)
        said = circle.stdout.read()
        assert circle.returncode == 0, said
        assert "largest distance from the newest setpoint" in said
