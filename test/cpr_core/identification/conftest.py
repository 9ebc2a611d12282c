# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The robot that most tests calibrate."""

import pytest

import cpr_core


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("six_rfs")


@pytest.fixture(scope="module")
def home(robot):
    return cpr_core.solve_home(robot)
