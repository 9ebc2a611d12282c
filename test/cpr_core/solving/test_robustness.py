# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Random far requests, there and back: the experiments of docs/robustness.md."""

import pytest

from benchmarks.robustness import COUNTS, ROBOTS, experiment


@pytest.mark.slow
@pytest.mark.parametrize("problem", COUNTS)
@pytest.mark.parametrize("name", ROBOTS)
def test_every_request_is_reached_or_stopped_by_a_real_event_and_leads_back(name, problem):
    found = experiment(name, problem, COUNTS[problem])
    assert sum(found.ends.values()) == COUNTS[problem]
    assert found.ends["lost"] == 0
    assert found.not_real == []
    assert found.not_equilibria == 0
    assert found.not_returned == []
    assert found.worst_return < 1e-7
