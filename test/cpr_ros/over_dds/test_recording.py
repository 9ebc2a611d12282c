# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The programs of the page about recording, one after the other, beside a real node."""

import ast
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
from cpr_msgs.msg import StabilityMetrics
from helpers.node_process import TIMEOUT

#: Messages that wait to be taken by the program of the page.
QUEUE = 100
PAGE = Path(__file__).parents[3] / "docs/recording.md"
TOPICS = ("/joint_states", "/cpr_node/stability")


def started(drive, program, argument, output=subprocess.PIPE):
    return subprocess.Popen(
        [sys.executable, "-c", program, argument],
        env=os.environ | {"ROS_DOMAIN_ID": str(drive.client.context.get_domain_id())},
        stdout=output,
        stderr=subprocess.STDOUT,
        text=True,
    )


def said(process):
    text, _ = process.communicate(timeout=60.0)
    assert process.returncode == 0, text
    return text.splitlines()


def test_what_is_recorded_is_read_again(drive, tmp_path):
    page = PAGE.read_text(encoding="utf-8")
    write, *reading = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    folder = tmp_path / "bag"
    log = tmp_path / "recorder.log"
    with log.open("w") as output:
        recorder = started(drive, write, folder, output)

    def counts():
        """Of the topic with fewest messages, every second."""
        assert recorder.poll() is None, log.read_text()
        lines = log.read_text().split("\n")[:-1]
        return [min(ast.literal_eval(line).values()) for line in lines]

    drive.client.spin_until(lambda: any(counts()), TIMEOUT)
    drive.send_motors(2.65, 0.5)
    drive.until(lambda: np.array_equal(drive.motors, [2.65, 0.5]))
    lines = len(counts())
    # So many more cannot have waited in its queue when the robot was there.
    drive.client.spin_until(
        lambda: len(counts()) > lines and counts()[-1] > counts()[lines] + QUEUE, TIMEOUT
    )
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(TIMEOUT) == 0, log.read_text()

    with_rosbags, with_mcap = reading
    lines = [line.split(maxsplit=2) for line in said(started(drive, with_rosbags, folder))]
    stamps = [float(stamp) for stamp, _, _ in lines]
    assert stamps == sorted(stamps)
    told = drive.all(StabilityMetrics)[-1]
    assert len(lines) > 5
    assert {text for _, _, text in lines} == {told.status_text}
    assert any(float(margin) == told.margin for _, margin, _ in lines)
    (file,) = folder.glob("*.mcap")
    lines = said(started(drive, with_mcap, file))
    assert len(lines) > 5
    assert any(line.endswith("[2.65, 0.5]") for line in lines)
