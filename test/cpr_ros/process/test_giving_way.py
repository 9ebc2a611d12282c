# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Who has sent a message sleeps for a moment, unless others take the processor for longer."""

import pytest

from cpr_ros.process.giving_way import GivingWay


class Processor:
    """Time that goes by as it is slept, and as long as others keep the processor then."""

    def __init__(self):
        self.now, self.kept, self.slept = 100.0, 0.0, []

    def clock(self):
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds + self.kept

    def giving_way(self, longest=1.0):
        return GivingWay(longest, self.clock, self.sleep)


def test_it_sleeps_as_long_as_asked_and_no_longer_than_it_may():
    processor = Processor()
    giving = processor.giving_way(longest=5e-4)
    for asked in (2e-4, 5e-4, 3e-3):
        giving.sleep(asked)
    assert processor.slept == [2e-4, 5e-4, 5e-4]


def test_woken_a_little_late_it_goes_on():
    processor = Processor()
    processor.kept = 5e-4
    giving = processor.giving_way()
    for _ in range(20):
        giving.sleep(2e-4)
    assert processor.slept == 20 * [2e-4]


@pytest.mark.parametrize("busy", [0.002, 0.5])
def test_where_others_keep_the_processor_it_does_not_sleep_for_a_while(busy):
    """A tick of 5 ms after the other: of forty, one finds out."""
    processor = Processor()
    processor.kept = busy
    giving = processor.giving_way()
    for _ in range(400):
        giving.sleep(2e-4)
        processor.now += 0.005
    assert 9 <= len(processor.slept) <= 11
    processor.kept = 0.0
    processor.now += 0.2
    processor.slept.clear()
    for _ in range(10):
        giving.sleep(2e-4)
    assert len(processor.slept) == 10
