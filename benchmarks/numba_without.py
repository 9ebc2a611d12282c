# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What each private interface of numba gains: compiling and solving with it and without.

    python -m benchmarks.numba_without --runs 2 > gains.json     # compiles everything 16 times

Cases take turns, each in processes of its own: one that compiles every kernel into an empty cache, and
others that load them from there and solve. Times are user time of the processor: for compiling of the
whole process, else of a call, the least of many samples.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

#: What can be hidden from the library, by the module of numba it takes it from.
INTERFACES = {
    "loop hint": ("numba.core.typed_passes", ("NativeLowering",)),
    "cache stamp": ("numba.core.caching", ("IndexDataCacheFile",)),
    "loaded code": ("numba.core.caching", ("CompileResultCacheImpl",)),
    "compile events": ("numba.core.event", ("install_listener",)),
    "_nrt": ("numba.core.cpu", ()),
    "forceinline": ("numba.core.cpu", ()),
    "no_cpython_wrapper": ("numba.core.cpu", ()),
    "no_cfunc_wrapper": ("numba.core.cpu", ()),
}
#: What is hidden in a case.
CASES = {
    "nothing": (),
    "loop hint": ("loop hint",),
    "references not counted": ("_nrt",),
    "forced inlining": ("forceinline",),
    "no wrappers": ("no_cpython_wrapper", "no_cfunc_wrapper"),
    "code loaded alone": ("loaded code",),
    "stamp of the cache": ("cache stamp",),
    "everything": ("loop hint", "_nrt", "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper"),
}
#: Robots, and motors near home [rad].
STARTS = {"rfrfr": (2.59, 0.55), "six_rfs": (5.86, 5.56, 5.86, 5.46, 5.86, 5.26)}


def hide(*interfaces: str) -> None:
    """Let the library find a numba without them; to be called before it is imported.

    numba itself keeps them: it goes on with the modules it has imported.
    """
    if "cpr_core" in sys.modules:
        raise RuntimeError("cpr_core has been imported already")
    import numba  # noqa: F401

    for interface in interfaces:
        name, members = INTERFACES[interface]
        module = import_module(name)
        copy = ModuleType(name)
        vars(copy).update({k: v for k, v in vars(module).items() if k not in members})
        if not members:  # an option that the compiler would refuse
            options = {k for k in dir(copy.CPUTargetOptions) if k != interface and k[:2] != "__"}
            copy.CPUTargetOptions = type(name, (), dict.fromkeys(options))  # type: ignore[attr-defined]
        sys.modules[name] = copy
        parent, _, last = name.rpartition(".")
        setattr(sys.modules[parent], last, copy)


def compile_all() -> dict[str, float]:
    """Compile every kernel in this process [s]."""
    from cpr_core.kernel_warmup import compile_kernels

    for _ in compile_kernels():
        pass
    return {"compile": _user_time()}


def start() -> dict[str, float]:
    """Import the library, load a robot and solve once, in this process [s]."""
    import cpr_core

    cpr_core.solve_forward(cpr_core.load_robot("six_rfs"), STARTS["six_rfs"])
    return {"process with one solve, six_rfs": _user_time()}


def solve_all() -> dict[str, float]:
    """Small steps of the robots of the paper, to and fro [s a step]."""
    import numpy as np

    import cpr_core

    found = {}
    for name, start in STARTS.items():
        robot = cpr_core.load_robot(name)
        reached = [cpr_core.solve_forward(robot, start)]
        rows = start + 0.2 * np.sin(np.linspace(0.0, 2.0 * np.pi, 51))[:, None] * np.ones(
            len(start)
        )

        def solve(robot: Any = robot, rows: Any = rows, reached: Any = reached) -> None:
            for row in rows:
                reached[0] = cpr_core.solve_forward(robot, row, start=reached[0])

        def follow(robot: Any = robot, rows: Any = rows, reached: Any = reached) -> None:
            cpr_core.trace_through(robot, motors=rows, start=reached[0], singularities=False)

        found[f"solve, {name}"] = _least(solve) / len(rows)
        found[f"step of a path, {name}"] = _least(follow) / len(rows)
    return found


def _user_time() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def _least(run: Callable[[], None], samples: int = 40, repeats: int = 10) -> float:
    run()
    times = []
    for _ in range(samples):
        begin = _user_time()
        for _ in range(repeats):
            run()
        times.append((_user_time() - begin) / repeats)
    return min(times)


def _in_process(case: str, part: str, cache: str) -> dict[str, float]:
    environment = os.environ | {"NUMBA_CACHE_DIR": cache, "OPENBLAS_NUM_THREADS": "1"}
    code = (
        "import json, warnings; warnings.simplefilter('ignore')\n"
        "from benchmarks import numba_without\n"
        f"numba_without.hide(*{CASES[case]!r})\n"
        f"print(json.dumps(numba_without.{part}()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, check=True
    )
    return json.loads(done.stdout)


def main() -> None:
    """Measure all cases, and print the least of every figure."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=int, default=2, help="how often every case is compiled")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    arguments = parser.parse_args()
    best: dict[str, dict[str, float]] = {case: {} for case in arguments.cases}
    for _ in range(arguments.runs):
        with tempfile.TemporaryDirectory() as folder:
            for part in ("compile_all", "start", "start", "solve_all", "solve_all", "solve_all"):
                for case in arguments.cases:
                    cache = os.path.join(folder, case.replace(" ", "-"))  # noqa: PTH118
                    for key, value in _in_process(case, part, cache).items():
                        best[case][key] = min(value, best[case].get(key, value))
                        print(f"{case}: {key}: {value:.4g} s", file=sys.stderr, flush=True)
    print(json.dumps(best, indent=2))


if __name__ == "__main__":
    main()
