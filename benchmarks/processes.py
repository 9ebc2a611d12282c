# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""New processes: importing, the first solve with a cold and with a warm kernel cache, peak memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import THREAD_VARIABLES
from .measure import Figure, summary_of

__all__ = ["process_figures"]

FIRST_SOLVE = """
import time
begin = time.perf_counter()
busy = time.process_time()
import cpr_core
imported = time.perf_counter()
busy_imported = time.process_time()
robot = cpr_core.load_robot("six_rfs")
bent = cpr_core.solve_forward(robot, cpr_core.solve_home(robot).motors + 0.02)
solved = time.perf_counter()
busy_solved = time.process_time()
assert bent.converged
import json
from pathlib import Path
peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024.0
print(json.dumps({
    "import": imported - begin,
    "import busy": busy_imported - busy,
    "first solve": solved - begin,
    "first solve busy": busy_solved - busy,
    "memory": peak,
}))
"""

MEMORY = """
import json
from pathlib import Path
import numpy as np
import cpr_core
robot = cpr_core.load_robot("six_rfs", modes=12)
home = bent = cpr_core.solve_home(robot)
for number in range(1000):
    bent = cpr_core.solve_forward(robot, home.motors + 0.1 * np.sin(0.01 * number), start=bent)
peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024.0
print(json.dumps(peak))
"""

#: As a user has it, who does not limit the threads of BLAS.
ALL_THREADS = """
import json, time
import cpr_core
home = cpr_core.solve_home(cpr_core.load_robot("six_rfs"))
samples = []
for _ in range(101):
    begin = time.perf_counter()
    cpr_core.spectrum(home, "locked"), cpr_core.spectrum(home, "free")
    cpr_core.kinemato_statics(home).jacobian
    samples.append(time.perf_counter() - begin)
print(json.dumps(samples[1:]))
"""


def process_figures(
    repeats: int, with_cold: bool, progress: Callable[[str], object] = lambda key: None
) -> dict[str, Figure]:
    """Measure new processes; a cold cache takes a minute.

    Times are those that pass from the first line of the process on; the start of Python is not in them.
    """
    figures = {}
    run(FIRST_SOLVE)  # the cache is warm from here on
    found = []
    for _ in range(repeats):
        progress("new process")
        found.append(run(FIRST_SOLVE))
    names = {"import": "import cpr_core", "first solve": "first solve, warm cache"}
    for key, name in names.items():
        figures[name] = summary_of([process[key] for process in found], "s", "wall")
        busy = [process[f"{key} busy"] for process in found]
        figures[f"{name}, processor time"] = summary_of(busy, "s", "processor")
    figures["peak memory, first solve"] = summary_of([process["memory"] for process in found], "MB")
    progress("peak memory")
    figures["peak memory, 1000 solves with 12 modes"] = summary_of([run(MEMORY)], "MB")
    progress("BLAS threads")
    name = "stability and kinemato-statics, BLAS threads not limited/six_rfs/5"
    figures[name] = summary_of(run(ALL_THREADS), "s", "wall")
    if with_cold:
        progress("cold cache")
        with tempfile.TemporaryDirectory() as folder:
            cold = run(FIRST_SOLVE, Path(folder))["first solve"]
        figures["first solve, cold cache"] = summary_of([cold], "s", "wall")
    return figures


def run(code: str, cache: Path | None = None) -> Any:
    """Run Python code in a new process; what it prints as JSON."""
    environment = {
        name: value for name, value in os.environ.items() if name not in THREAD_VARIABLES
    }
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    return json.loads(done.stdout)
