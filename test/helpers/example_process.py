# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""An example as a user starts it, in the domain of a client."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import IO

from helpers.node_process import Client
from helpers.own_tree import ROOT

EXAMPLES = ROOT / "examples"


def started_example(
    client: Client,
    name: str,
    *arguments: str,
    cwd: Path | None = None,
    stdout: int | IO[str] = subprocess.PIPE,
) -> subprocess.Popen[str]:
    """Start it; what it says goes, lines of errors too, to one place."""
    domain = str(client.context.get_domain_id())
    return subprocess.Popen(
        [sys.executable, EXAMPLES / name, *arguments],
        env=os.environ | {"ROS_DOMAIN_ID": domain, "PYTHONUNBUFFERED": "1"},
        cwd=cwd,
        stdout=stdout,
        stderr=subprocess.STDOUT,
        text=True,
    )
