# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Who is in control of a page, and what was asked for."""

import threading
import time

from cpr_ros.page.page_control import PageControl


def test_only_who_is_in_control_is_heard():
    control = PageControl()
    assert not control.ask(2, 1.0) and not control.asks
    control.take()
    assert control.ask(0, 1.0)
    assert control.ask(1, 2.0)
    assert control.ask(0, 3.0)
    assert control.take_asked() == {0: 3.0, 1: 2.0}
    assert control.take_asked() == {}


def test_what_was_asked_ends_with_the_control():
    control = PageControl()
    control.take()
    control.ask(0, 1.0)
    assert control.asks
    assert control.give_back()
    assert not control.taken and not control.asks
    assert control.take_asked() == {}
    assert not control.give_back()


def test_who_takes_or_gives_back_what_another_has_taken_or_given_back_changes_nothing():
    """Two that press one button: the second took control as both gave it back."""
    control = PageControl()
    for _ in range(2):
        control.take()
        assert control.ask(0, 1.0)
    assert control.take_asked() == {0: 1.0}
    for _ in range(2):
        control.give_back()
        assert not control.taken


def test_a_double_click_that_gives_control_back_does_not_take_it_again():
    """The second click hit the other button, which had come to the same place meanwhile."""
    now = [0.0]
    control = PageControl(lambda: now[0])
    control.take()
    control.give_back(pressed=True)
    now[0] += 0.4
    control.take()
    assert not control.taken and not control.ask(0, 1.0)
    now[0] += 0.4
    control.give_back(pressed=True)  # a third one is no news
    now[0] += 0.3
    control.take()
    assert control.taken
    control.give_back()  # as the node is gone: nobody has clicked
    control.take()
    assert control.taken


def test_nothing_is_lost_that_is_asked_while_something_is_taken():
    class Motor(int):
        """Its number is known after a while, so that the other thread comes between."""

        def __hash__(self):
            time.sleep(1e-3)
            return super().__hash__()

    control, taken = PageControl(), {}
    control.take()
    asking = threading.Thread(
        target=lambda: [control.ask(Motor(number), 0.1 * number) for number in range(20)]
    )
    asking.start()
    while asking.is_alive():
        taken |= {int(number): position for number, position in control.take_asked().items()}
    taken |= {int(number): position for number, position in control.take_asked().items()}
    assert taken == {number: 0.1 * number for number in range(20)}
