# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Answers that are kept with a robot."""

import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

from cpr_core import load_robot
from cpr_core.model.robot import kept_with_robot


def test_threads_that_search_at_once_keep_the_same():
    robot, together = load_robot("rfrfr"), threading.Barrier(4)

    @kept_with_robot
    def find(searched, number):
        assert searched is robot
        together.wait(timeout=60)
        return object()

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: find(robot, 7), range(4)))
    assert len(set(found)) == 1
    assert find(robot, 7) is found[0]
    together.abort()
    with pytest.raises(threading.BrokenBarrierError):
        find(robot, 8)  # another question: searched for again


def test_so_many_answers_are_kept_and_the_oldest_go_first():
    robot, asked = load_robot("rfrfr"), []

    @partial(kept_with_robot, most=2, by=lambda numbers: numbers.tobytes())
    def find(_, numbers):
        asked.append(numbers.tolist())  # None is an answer as any other

    for number in (1, 2, 1, 3, 2, 1, 3):
        find(robot, np.array([number]))
    assert asked == [[1], [2], [3], [1]]
