# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Fixtures: a follower of each paper robot."""

import pytest
from helpers.drive import Drive, robot


@pytest.fixture
def rfrfr() -> Drive:
    return Drive(robot("rfrfr"))


@pytest.fixture
def six_rfs() -> Drive:
    return Drive(robot("six_rfs"))
