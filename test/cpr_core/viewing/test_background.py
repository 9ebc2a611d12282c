# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Work beside the page: newer takes the place of older, of which nothing comes any more."""

import threading
import time

import pytest

from cpr_core.viewing.background import Background
from cpr_core.viewing.mailbox import Mailbox


def test_newer_work_of_a_kind_stops_the_older():
    failures, ended, begun = [], [], threading.Event()
    background = Background(nothing_is_done, failures.append)

    def work(task):
        begun.set()
        while not task.stopped():
            pass
        ended.append("older")

    background.start("search", work)
    assert begun.wait(10.0)
    newer = threading.Event()
    background.start("search", lambda task: newer.set())
    assert newer.wait(10.0)
    background.close()
    assert ended == ["older"]
    assert failures == []
    background.start("search", lambda task: ended.append("after the end"))
    assert ended == ["older"]


def test_of_work_that_several_threads_start_one_goes_on():
    class Kind(str):
        """Looking for it takes so long that the other thread comes between."""

        def __hash__(self):
            time.sleep(1e-3)
            return super().__hash__()

    tasks = []
    background = Background(nothing_is_done, pytest.fail)
    together = threading.Barrier(2)

    def start():
        together.wait(10.0)
        for _ in range(5):
            background.start(Kind("search"), tasks.append)

    other = threading.Thread(target=start)
    other.start()
    start()
    other.join()
    background_threads = [thread for thread in threading.enumerate() if "search" in thread.name]
    for thread in background_threads:
        thread.join()
    assert len(tasks) == 10
    assert sum(not task.stopped() for task in tasks) == 1
    background.close()


def test_nothing_comes_of_what_stopped_work_has_posted():
    """Neither of what waits already, nor of what it posts afterwards: that replaces nothing newer."""
    done, tasks = [], []
    free = threading.Event()
    mailbox = Mailbox(pytest.fail)
    background = Background(
        lambda name, action: mailbox.ask(name, lambda: action(None)), pytest.fail
    )
    mailbox.ask("hold", lambda: free.wait(10.0))

    def work(task):
        number = len(tasks)  # nobody else begins meanwhile
        task.post("result", lambda _: done.append(number))
        tasks.append(task)

    for number in range(3):
        background.start("search", work)
        while len(tasks) <= number:
            time.sleep(1e-3)
    background.start("other", work)
    while len(tasks) < 4:
        time.sleep(1e-3)
    for task in tasks[:2]:
        task.post("result", lambda _: done.append("late"))
    free.set()
    assert mailbox.wait(10.0)
    assert done == [2, 3]
    background.close()
    mailbox.close()


def nothing_is_done(name, action):
    """The page of whoever posts nothing."""
    raise AssertionError(name)
