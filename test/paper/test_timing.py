# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is measured is the same path for all models; no time is asserted."""

import numpy as np
import pytest

from cpr_core import NoForwardSolution
from cpr_core.reference.continuous_rods import follow_motors
from cpr_core.reference.shooting_method import ShootingMethod
from paper import timing
from paper.cases import RFRFR
from paper.claims import time_claims
from paper.timing import Measurement, Model


@pytest.fixture(scope="module")
def models():
    method = ShootingMethod("RK4", 20, 1e-10)
    return {model.key: model for model in timing.models_of(RFRFR, method)}


def test_every_model_follows_the_path(models):
    assert set(models) == {"#1", "#2", "#2 exact", "#3", "#0"}
    largest = {"#1": 1e-4, "#2": 1e-5, "#2 exact": 1e-10, "#3": 2e-3, "#0": 2e-4}
    for key, found in timing.measure(models.values(), RFRFR, 10, 2, 1).items():
        assert found is not None
        assert (found.model, found.count) == (key, 10)
        assert found.repeats == (1 if models[key].slow else 2)
        assert found.mean_error < largest[key]
        assert found.seconds > 0.0
        assert found.iterations > 1.0


def test_a_model_that_leaves_the_branch_is_not_measured(models):
    def elsewhere(path):
        return models["#1"].run(path[::-1])

    def nowhere(path):
        raise NoForwardSolution("lost", 0.0, None)

    lost = [Model("elsewhere", "", elsewhere), Model("nowhere", "", nowhere)]
    assert timing.measure(lost, RFRFR, 10, 1, 1) == {"elsewhere": None, "nowhere": None}


def test_the_comparable_setting_is_as_accurate_as_five_modes():
    method = timing.comparable_method(RFRFR)
    exact = RFRFR.continuous_path()
    found = follow_motors(RFRFR.continuous_home(), RFRFR.path(), method=method)

    def mean(points):
        pairs = zip(points, exact, strict=True)
        return np.mean(
            [np.linalg.norm(a.platform_position - b.platform_position) for a, b in pairs]
        )

    assert mean(found) <= mean(RFRFR.modes_path(5))
    assert method.steps < timing.EXACT_METHOD.steps


def test_claims_follow_from_the_measurements():
    def times(**seconds):
        return {
            (key.replace("_", "#").replace("E", " exact"), 50): Measurement(
                key, 50, value, 1.0, 1, 0.0, 3.0
            )
            for key, value in seconds.items()
        }

    planar = times(_1=1.0, _2=4.0, _2E=2.0, _3=150.0)
    spatial = times(_1=1.0, _2=1.0, _2E=9.0)
    met = [claim.met for claim in time_claims(planar, spatial, 50)]
    assert met == [True, False, True, False, False, True]


def test_the_machine_is_named():
    name, cores = timing.machine().rsplit(", ", 1)
    assert name
    assert int(cores.split()[0]) >= 1
