# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random far requests, there and back: the experiments of docs/robustness.md."""

import pytest

from benchmarks.robustness import COUNTS, ROBOTS, Requests, experiment


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_every_request_is_reached_or_stopped_by_a_real_event_and_leads_back(name):
    """All problems of a robot together: they share the walks that lead to what is asked for."""
    requests = Requests(name)
    for problem, count in COUNTS.items():
        found = experiment(requests, problem, count)
        assert sum(found.ends.values()) == count, problem
        assert found.ends["lost"] == 0, problem
        assert found.not_real == [], problem
        assert found.not_equilibria == 0, problem
        assert found.not_returned == [], problem
        assert found.worst_return < 1e-7, problem
