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


def test_work_of_every_kind_ends_with_the_page_and_its_failure_is_told():
    failures, tasks = [], []
    background = Background(nothing_is_done, failures.append)

    def work(task):
        tasks.append(task)
        while not task.stopped():
            time.sleep(1e-3)
        if len(failures) < 1:
            raise ArithmeticError("at its end")

    for kind in ("search", "play"):
        background.start(kind, work)
    threads = [*background._threads]
    while len(tasks) < 2:
        time.sleep(1e-3)
    background.close()
    assert len(threads) == 2 and not any(thread.is_alive() for thread in threads)
    assert {type(failure) for failure in failures} == {ArithmeticError}


def test_work_that_closes_the_page_does_not_wait_for_itself():
    failures = []
    background = Background(nothing_is_done, failures.append)
    mailbox = Mailbox(failures.append)
    background.start("search", lambda task: background.close())
    for thread in [*background._threads]:
        thread.join(10.0)
    mailbox.ask("close", mailbox.close)
    mailbox._thread.join(10.0)
    assert failures == [] and not mailbox._thread.is_alive()


def test_who_waits_waits_for_what_is_under_way():
    begun, free = threading.Event(), threading.Event()
    mailbox = Mailbox(pytest.fail)

    def work():
        begun.set()
        free.wait(10.0)

    mailbox.ask("work", work)
    assert begun.wait(10.0)
    assert not mailbox.wait(0.0)
    free.set()
    assert mailbox.wait(10.0)
    mailbox.close()


def test_what_is_asked_again_is_done_as_early_as_it_was_due():
    """What comes all the time would be put off all the time."""
    done, free = [], threading.Event()
    mailbox = Mailbox(pytest.fail)
    mailbox.ask("hold", lambda: free.wait(10.0))
    mailbox.ask("numbers", lambda: done.append("older"))
    mailbox.ask("numbers", lambda: done.append("newer"), delay=100.0)
    free.set()
    assert mailbox.wait(10.0)
    assert done == ["newer"]
    mailbox.ask("late", lambda: done.append("late"), delay=100.0)
    mailbox.close()
    assert mailbox.wait(0.0) and done == ["newer"]  # nobody waits for what is never done


def nothing_is_done(name, action):
    """The page of whoever posts nothing."""
    raise AssertionError(name)
