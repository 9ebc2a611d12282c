# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a calibration tries on its way is not doubted, as a file with such numbers is."""

import warnings

import pytest

from cpr_core import DescriptionError, DescriptionWarning, load_robot
from cpr_core.identification.tried_robot import tried_robot


def test_numbers_that_are_only_tried_are_not_doubted():
    robot, values = load_robot("rfrfr"), {"rod.young_modulus": 2e10}
    with pytest.warns(DescriptionWarning, match="the shear modulus"):
        changed = robot.with_parameters(values)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tried = tried_robot(robot, values)
    assert tried.parameter_values([*values]) == changed.parameter_values([*values]) == [2e10]
    with pytest.raises(DescriptionError, match="young_modulus"):
        tried_robot(robot, {"rod.young_modulus": -1.0})
