# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is printed where standard output is left, full, closed or of few letters; and warnings."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from helpers.yaml_content import shipped_content

from cpr_core.description.description_file import shipped_robots

pytestmark = pytest.mark.usefixtures("compiled")  # no command has to say that it compiles

CPR = (sys.executable, "-m", "cpr_core.command_line")
ANSWERED = ("forward", "rfrfr", "--motors", "2.59", "0.55")
REFUSED = ("inverse", "rfrfr", "--pose", "9", "9", "--json")
#: As at a terminal of one's own: what is printed waits for more.
BUFFERED = os.environ | {"PYTHONUNBUFFERED": ""}
PRINTED = ("answer", "refusal", "help")


@pytest.mark.parametrize("arguments", [ANSWERED, REFUSED, ("--help",)], ids=PRINTED)
def test_a_reader_who_leaves_is_no_error(arguments):
    """As `cpr ... | head`."""
    process = subprocess.Popen(
        [*CPR, *arguments],
        env=BUFFERED,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.close()
    assert (process.stderr.read(), process.wait(60)) == ("", 141)


@pytest.mark.parametrize(
    "arguments", [ANSWERED, (*ANSWERED, "--json"), REFUSED, ("--help",)], ids=["text", *PRINTED]
)
def test_an_answer_that_cannot_be_printed_is_an_error_in_a_line(arguments):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*CPR, *arguments], env=BUFFERED, stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 1
    assert done.stderr == "cpr: error: [Errno 28] No space left on device\n"


def test_a_closed_output_is_an_error_in_a_line():
    command = [*CPR, *ANSWERED]
    done = subprocess.run(
        ["sh", "-c", '"$@" >&-', "sh", *command], stderr=subprocess.PIPE, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (1, "cpr: error: standard output is closed\n")


def test_letters_that_the_output_does_not_have_are_escaped(tmp_path):
    robot = tmp_path / "robot.yaml"
    text = shipped_robots()["rfrfr"].read_text()
    assert text.count("name: rfrfr") == 1
    robot.write_text(text.replace("name: rfrfr", "name: stäbe"), encoding="utf-8")
    for encoding, name in (("ascii", r"st\xe4be"), ("utf-8", "stäbe")):
        done = subprocess.run(
            [*CPR, "forward", robot, *ANSWERED[2:]],
            env=os.environ | {"PYTHONIOENCODING": encoding},
            capture_output=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        assert done.stdout.decode(encoding).startswith(f"{name}: equilibrium")


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_warnings_are_lines_without_source_code(tmp_path, options):
    """They came as Python's: with the file of cpr_core that warns, and its code."""
    content = shipped_content("rfrfr")
    content["home"]["platform"] = {"position": [3.0, 0.0, 0.0]}
    robot = tmp_path / "far.yaml"
    robot.write_text(yaml.safe_dump(content), encoding="utf-8")
    command = [*CPR, "forward", str(robot), *ANSWERED[2:], *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    begin = f"cpr: warning: {robot}: home.platform.position: the home equilibrium found is "
    assert done.returncode == 0
    assert done.stderr.startswith(begin) and done.stderr.count("\n") == 1
    assert "warning" not in done.stdout
    if options:
        assert json.loads(done.stdout)["converged"]
