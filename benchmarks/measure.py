# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Measuring many cases in one process, so that what disturbs the machine befalls them all alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

__all__ = ["Case", "Figure", "measure", "summary_of"]

#: A sample takes at least this long [s]; short cases are run several times for it.
SHORTEST_SAMPLE = 2e-3


@dataclass(frozen=True)
class Case:
    """Something to be measured.

    Attributes:
        key: Unique name; parts are separated by slashes.
        run: Does it.
        count: How many operations one run does.
        clock: ``processor``: of this thread, so waiting for a core does not count; ``wall``: passed.
        slow: Whether one run takes seconds: then it is repeated less.
    """

    key: str
    run: Callable[[], object]
    count: int = 1
    clock: Literal["processor", "wall"] = "processor"
    slow: bool = False


@dataclass(frozen=True)
class Figure:
    """What was found for a case.

    Attributes:
        median: Median of the samples, in the unit.
        first_quartile: A quarter of the samples is below.
        third_quartile: A quarter of the samples is above.
        smallest: The smallest sample.
        samples: Number of samples.
        unit: ``s`` or ``MB``.
        clock: ``processor`` or ``wall``; empty where it is no time.
    """

    median: float
    first_quartile: float
    third_quartile: float
    smallest: float
    samples: int
    unit: str = "s"
    clock: str = ""


def summary_of(samples: Sequence[float], unit: str = "s", clock: str = "") -> Figure:
    """Median and spread of samples."""
    first, middle, third = np.percentile(samples, [25, 50, 75]).tolist()
    return Figure(middle, first, third, float(np.min(samples)), len(samples), unit, clock)


def measure(
    cases: Sequence[Case],
    repeats: int,
    slow_repeats: int,
    progress: Callable[[str], object] = lambda key: None,
) -> dict[str, Figure]:
    """Measure cases, taking turns in an order that changes from round to round.

    Every case is run once before, to warm up. The garbage collector rests during a sample.

    Args:
        cases: The cases.
        repeats: Samples of a case.
        slow_repeats: Samples of a slow one.
        progress: Called with the key of a case before every sample.
    """
    keys = [case.key for case in cases]
    if len(set(keys)) != len(keys):
        raise ValueError(
            f"keys given twice: {sorted({key for key in keys if keys.count(key) > 1})}"
        )
    loops = {}
    for case in cases:
        progress(case.key)
        loops[case.key] = max(1, int(np.ceil(SHORTEST_SAMPLE / max(1e-9, _warm(case)))))
    samples: dict[str, list[float]] = {key: [] for key in keys}
    random = np.random.default_rng(0)
    for turn in range(max(repeats, slow_repeats)):
        for number in random.permutation(len(cases)).tolist():
            case = cases[number]
            if turn < (slow_repeats if case.slow else repeats):
                progress(case.key)
                seconds = _sample(case, loops[case.key])
                samples[case.key].append(seconds / (case.count * loops[case.key]))
    return {case.key: summary_of(samples[case.key], "s", case.clock) for case in cases}


def _warm(case: Case) -> float:
    """Run a case until it is warm; the time of a run."""
    first = _sample(case, 1)
    return first if case.slow or first > 0.2 else _sample(case, 1)


def _sample(case: Case, loops: int) -> float:
    clock = time.thread_time if case.clock == "processor" else time.perf_counter
    collecting = gc.isenabled()
    gc.collect(0)
    gc.disable()
    try:
        begin = clock()
        for _ in range(loops):
            case.run()
        return clock() - begin
    finally:
        if collecting:
            gc.enable()
