# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Values that hold arrays are compared and hashed as objects: entries have no single answer."""

import copy
from dataclasses import is_dataclass
from typing import get_args, get_origin, get_type_hints

import numpy as np
from helpers.defined_classes import classes_of

import cpr_core
import cpr_core.workspace
from cpr_core import leg_shapes, load_robot, solve_home

PUBLIC = [
    getattr(package, name) for package in (cpr_core, cpr_core.workspace) for name in package.__all__
]


def holds_arrays(hint):
    """Whether a type is that of arrays, alone, as an option or in a tuple."""
    return get_origin(hint) is np.ndarray or any(map(holds_arrays, get_args(hint)))


def test_dataclasses_and_all_public_values_with_arrays_are_compared_as_objects():
    kinds = [kind for kind in classes_of(cpr_core) if is_dataclass(kind) or kind in PUBLIC]
    with_arrays = [kind for kind in kinds if any(map(holds_arrays, get_type_hints(kind).values()))]
    assert len(with_arrays) > 60
    wrong = [kind for kind in with_arrays if kind.__eq__ is not object.__eq__]
    assert wrong == []


def test_joints_of_shapes_are_compared_as_objects():
    joint = leg_shapes(solve_home(load_robot("rfrfr")))[0].joints[0]
    assert joint != copy.deepcopy(joint)
    assert len({joint, copy.deepcopy(joint)}) == 2
