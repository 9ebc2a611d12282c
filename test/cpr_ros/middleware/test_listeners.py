# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Whether anybody listens, and how often DDS is asked."""

from cpr_ros.middleware.listeners import Listeners
from cpr_ros.process.periodic import LOOK


class Publisher:
    def __init__(self):
        self.count, self.asked = 0, 0

    def get_subscription_count(self):
        self.asked += 1
        return self.count


def test_what_is_said_once_is_asked_for_every_time():
    publisher = Publisher()
    listeners = Listeners(publisher)
    assert not listeners.now(5.0)
    publisher.count = 2
    assert listeners.now(5.0)
    assert listeners.lately(5.001)  # known since then
    publisher.count = 0
    assert not listeners.now(5.002)


def test_what_is_said_again_soon_is_asked_for_ten_times_a_second():
    publisher = Publisher()
    listeners, heard = Listeners(publisher), []
    for number in range(1000):
        publisher.count = int(500 <= number < 750)
        if listeners.lately(0.01 * number):
            heard.append(number)
    assert 95 <= publisher.asked <= 115
    assert 500 <= heard[0] <= 500 + 100 * LOOK
    assert 750 <= heard[-1] + 1 <= 750 + 100 * LOOK
    assert len(heard) == heard[-1] - heard[0] + 1
