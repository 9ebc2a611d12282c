# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Start and end of the node's process."""

import os
import signal
import subprocess
import sys

import pytest
from helpers.imported_node import imported_node
from helpers.node_process import TIMEOUT, NodeProcess, free_domain
from helpers.own_tree import ROOT


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_node_cleanly(tmp_path, how):
    arguments = ["-p", "robot:=rfrfr"]
    process = NodeProcess(tmp_path / "node.log", free_domain(), arguments, cold=True)
    process.wait_for_log("ready")
    assert process.stop(how) == 0
    assert "Traceback" not in process.output()


def test_sigterm_during_the_start_ends_the_node_cleanly(tmp_path):
    arguments = ["-p", "robot:=six_rfs"]
    with imported_node() as imported:
        for text in ("motors motor1", "finding home", "at home after"):
            log = tmp_path / f"{text}.log"
            process = NodeProcess(log, free_domain(), arguments, imported=imported)
            process.wait_for_log(text)
            assert process.stop(signal.SIGTERM) == 0, process.output()
            assert "Traceback" not in process.output()


LEFT = '''
import gc, os, signal, sys, threading, time
from contextlib import suppress
from pathlib import Path
from cpr_ros import cpr_node, node, node_run, whereabouts
from cpr_ros.process.stop_signal import StopSignal

def locked():
    """Segments of this process: it holds their locks. Others of any domain may be mapped as well, for a
    second after they are needed: ports that a dead process has left go to the next one, mail and all."""
    for information in Path("/proc/self/fdinfo").iterdir():
        with suppress(OSError):  # closed meanwhile
            file = os.readlink(f"/proc/self/fd/{information.name}")
            if "/fastrtps_" in file and "_port" not in file and "lock:" in information.read_text():
                yield file.removesuffix("_el")

made = set()

class Node(node.CprNode):
    def __init__(self, stop):
        try:
            super().__init__(stop)
        finally:
            made.update(locked())
        how = sys.argv[1]
        if how == "stopped":
            signal.raise_signal(signal.SIGTERM)
        elif how == "broken":
            raise node.CprError("broken")
        elif how == "looking":
            whereabouts._DISCOVERY = 30.0

    def count_publishers(self, topic):
        if sys.argv[1] == "looking":
            with self.handle:
                threading.Timer(0.1, os.kill, [os.getpid(), signal.SIGTERM]).start()
                time.sleep(1.0)
        return super().count_publishers(topic)

run, finish = node_run.run, StopSignal.finish
def looking(stop, status):
    left = [name for name in {*made, *locked()} if Path(name).exists()]
    print("left:" if made else "none was made:", *left)
    print("garbage is looked for:", gc.isenabled())
    finish(stop, status)

StopSignal.finish = looking
node_run.run = lambda _, *given: run(Node, *given)
cpr_node.main(["cpr_node", "--ros-args", "-p", "robot:=" + sys.argv[2]])
'''


@pytest.mark.parametrize(
    ("how", "robot", "status"),
    [
        ("stopped", "rfrfr", 0),
        ("broken", "rfrfr", 1),
        ("looking", "rfrfr", 0),
        ("", "no_such_robot", 1),
    ],
)
def test_a_node_that_ends_leaves_nothing_in_shared_memory(how, robot, status):
    """What DDS has there would stay until the machine is started again; nor does it keep garbage."""
    done = subprocess.run(
        [sys.executable, "-c", LEFT, how, robot],
        env=os.environ | {"ROS_DOMAIN_ID": str(free_domain())},
        capture_output=True,
        text=True,
        timeout=60,
    )
    said = "left:\ngarbage is looked for: True\n"
    assert (done.returncode, done.stdout) == (status, said), done.stderr


@pytest.mark.slow(seconds=70)
def test_signals_at_random_times_from_the_very_start_end_the_node_cleanly():
    """Some without compiled kernels, some with two signals; seeds of what fails are printed."""
    done = subprocess.run(
        [
            *(sys.executable, ROOT / "tools/stop_at_random.py"),
            *("--starts", "40", "--seed", "1", "--compiling", "6"),
        ],
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_an_unknown_parameter_in_a_file_is_warned_about(tmp_path):
    """The file may be meant for other nodes too."""
    file = tmp_path / "parameters.yaml"
    file.write_text("/**:\n  ros__parameters:\n    robot: rfrfr\n    margin_stp: 0.1\n")
    process = NodeProcess(tmp_path / "node.log", free_domain(), ["--params-file", str(file)])
    process.wait_for_log("ready")
    assert process.stop() == 0
    warned = [line for line in process.output().splitlines() if "[WARN]" in line]
    assert len(warned) == 1
    assert "unknown parameter margin_stp: did you mean margin_stop?" in warned[0]


def test_a_number_that_looks_like_another_unit_is_told_in_the_log(tmp_path):
    file = tmp_path / "robot.yaml"
    shipped = (ROOT / "config/rfrfr.yaml").read_text()
    file.write_text(shipped.replace("density: 7800 ", "density: 7.8 "))
    process = NodeProcess(tmp_path / "node.log", free_domain(), ["-p", f"robot:={file}"])
    process.wait_for_log("ready")
    assert process.stop() == 0
    told = [line for line in process.output().splitlines() if "looks like g/cm^3" in line]
    assert len(told) == 1
    assert told[0].startswith("[WARN]")
    assert f"]: {file}: rod.density" in told[0]
    assert "DescriptionWarning" not in process.output()  # nor source code, which Python adds


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["-p", "robot:=no_such_robot"], "no such file, nor a shipped robot"),
        (["-p", "robot:=rfrfr", "-p", "margin_stop:=0.5"], "expected margin_stop below"),
        (["-p", "robot:=rfrfr", "-p", "start_from:=last"], "where the robot was last is not known"),
        (["-p", "robot:=rfrfr", "-p", "base_frame:=platform"], "expected two frames"),
        (["-p", "robot:=TRACKED", "-p", "tracker_frame:=base"], "base is another one"),
        (["-p", "robot:=TRACKED", "-p", "platform_frame:=tracker_marker"], "is another one"),
        (["-p", "robot:=TRACKED", "-p", "tracker_frame:=''"], "expected a name"),
        (["-p", "nonsense"], "nonsense"),
        (["-p", "robot:=rfrfr", "-p", "modes:=500"], "modes"),
        (["-p", "robot:=rfrfr", "-p", "modes:=three"], "modes"),
    ],
)
def test_a_node_that_cannot_start_says_why_and_exits_with_1(tmp_path, arguments, text):
    file = tmp_path / "tracked.yaml"
    file.write_text(f"{(ROOT / 'config/rfrfr.yaml').read_text()}\ntracker: {{}}\n")
    arguments = [word.replace("TRACKED", str(file)) for word in arguments]
    process = NodeProcess(tmp_path / "node.log", free_domain(), arguments)
    assert process.process.wait(TIMEOUT) == 1
    told = [line for line in process.output().splitlines() if text in line]
    assert len(told) == 1
    assert "Traceback" not in process.output()


def test_where_no_log_can_be_written_is_said_in_a_line(tmp_path, monkeypatch):
    """rclpy raises before there is a node."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "file" / "log"))
    process = NodeProcess(tmp_path / "node.log", free_domain(), ["-p", "robot:=rfrfr"])
    assert process.process.wait(TIMEOUT) == 1
    assert "cpr_node: failed to initialize logging" in process.output()
    assert "Traceback" not in process.output()


def test_two_nodes_with_other_robots_live_in_two_namespaces(tmp_path):
    domain = free_domain()
    processes = [
        NodeProcess(
            tmp_path / f"{robot}.log",
            domain,
            ["-p", f"robot:={robot}", "-r", f"__ns:=/{robot}"],
        )
        for robot in ("rfrfr", "six_rfs")
    ]
    for process in processes:
        process.wait_for_log("ready")
    assert [process.stop() for process in processes] == [0, 0]
