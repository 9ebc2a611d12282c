# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

from cpr_ros.middleware.dropped_messages import DroppedMessages


def test_one_line_a_second_and_topic_and_every_message_counted():
    dropped = DroppedMessages()
    assert dropped.add("a", "NaN", 0.0) == "a: dropped: NaN"
    assert dropped.add("a", "NaN", 0.1) == ""
    assert dropped.add("b", "names", 0.2) == "b: dropped: names"
    assert dropped.add("a", "NaN", 0.9) == ""
    assert dropped.add("a", "NaN", 1.1) == "a: dropped: NaN (and 2 more since the last such line)"
    assert dropped.counts == {"a": 4, "b": 1}


def test_a_long_problem_makes_no_long_line():
    assert len(DroppedMessages().add("a", "x" * 100_000, 0.0)) < 600


def test_the_newest_are_those_since_one_looked_last():
    dropped = DroppedMessages()
    assert dropped.newest() == {}
    dropped.add("a", "NaN", 0.0)
    dropped.add("a", "NaN", 0.1)
    dropped.add("b", "NaN", 0.2)
    assert dropped.newest() == {"a": 2, "b": 1}
    dropped.add("b", "NaN", 0.3)
    assert dropped.newest() == {"b": 1}
    assert dropped.newest() == {}
    assert dropped.counts == {"a": 2, "b": 2}
