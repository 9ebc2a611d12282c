# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Live parameters that cannot be used."""

import math
import re

import pytest
from helpers.closed_loop import live

from cpr_ros.settings.node_settings import live_problem
from cpr_ros.settings.parameter_table import PARAMETERS

NUMBERS = [each.name for each in PARAMETERS if each.live and isinstance(each.default, float)]


@pytest.mark.parametrize("name", NUMBERS)
def test_one_that_is_no_number_is_named_as_it_was_set(name):
    """`loop_gain` was called `gain`, and `measured_pose_jump` `jump`."""
    assert live_problem(live()) == ""
    assert re.search(rf"\b{name}\b", live_problem(live(**{name: math.nan})))
