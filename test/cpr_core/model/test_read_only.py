# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Arrays that are kept and shared are not written to: what is solved later would be wrong."""

import inspect
import sys
from collections.abc import Mapping
from enum import Enum

import numpy as np
import pytest
from helpers.workspace_cases import small_map
from numba.core.dispatcher import Dispatcher

import cpr_core
import cpr_core.workspace
from cpr_core import (
    DistributedForce,
    Measurement,
    PointForce,
    StandardDeviations,
    calibrate,
    critical_load,
    derivatives,
    error_of,
    estimate_wrench,
    find_equilibria,
    kinemato_statics,
    leg_shapes,
    load_robot,
    propose_poses,
    solve_forward,
    solve_home,
    trace,
)
from cpr_core.kernels.kernel_arrays import LoadArrays, RobotArrays
from cpr_core.kernels.prepared_robot import PreparedRobot
from cpr_core.model.state_numbers import StateNumbers
from cpr_core.rods.quadrature import RodGrid
from cpr_core.workspace import summary_of

#: What the kernels take as it is, and what is described to them.
OF_KERNELS = (LoadArrays, PreparedRobot, RobotArrays, RodGrid, StateNumbers)
NAMES_OF_KERNELS = {"description", "factors", "known_factors", "record"}
#: Classes of all values that are answers.
ANSWERS = {
    kind
    for package in (cpr_core, cpr_core.workspace)
    for kind in (getattr(package, name) for name in package.__all__)
    if inspect.isclass(kind) and not issubclass(kind, Enum | Exception)
}


@pytest.mark.parametrize("name", ["three_prs", "planar_body"])
def test_arrays_that_are_kept_are_read_only(name):
    """`units = robot.motor_units; units *= 100` changed all answers."""
    robot = load_robot(name)
    home = solve_home(robot)
    for kept in (
        robot.motor_units,
        robot.yield_strains,
        kinemato_statics(home).body_tangent,
        home.platform_quaternion,
        home.spectrum_locked.eigenvalues,
        home.spectrum_locked.motions,
    ):
        with pytest.raises(ValueError, match="read-only"):
            kept *= 2


def answers(name):
    """Answers of every kind but those about maps and critical loads."""
    robot, parameters = load_robot(name), ["rod.young_modulus"]
    home, deviations = solve_home(robot), StandardDeviations(position=1e-4, rotation=1e-3)
    model, poses = kinemato_statics(home), propose_poses(robot, parameters, deviations, 3)
    near = home.motors + 0.02 * robot.motor_units
    measurements = [
        Measurement(
            motors=reached.motors,
            position=reached.platform_position,
            quaternion_wxyz=reached.platform_quaternion,
        )
        for reached in poses.equilibria
    ]
    force = [0.0, 0.1, 0.0]
    leg = robot.rod_names[0]
    return [
        home,
        DistributedForce(leg, [0.0, 1.0], [force, force]),
        PointForce(leg, 0.5, force),
        calibrate(robot, measurements, parameters, deviations),
        derivatives(home, parameters, of=("pose", "margin")),
        deviations,
        error_of(home),
        estimate_wrench(robot, home.motors, efforts=home.efforts, effort_deviation=1e-3),
        find_equilibria(robot, near, starts=3),
        leg_shapes(home),
        measurements,
        model,
        model.predict_forward(near - home.motors),
        model.singularity("forward"),
        poses,
        trace(robot, motors=near, points=3),
        trace(robot, motors=home.motors + 30.0, points=3).stopped,
    ]


class Walk:
    """What is found in answers, and in the answers these hold."""

    def __init__(self):
        self.kinds, self.kept, self.writeable = set(), 0, []
        self._seen = {}

    def look(self, value, again, path):
        """At a value, and what is told when it is asked for again."""
        if isinstance(value, np.ndarray):
            if value is again or np.shares_memory(value, again):
                self.kept += 1
                self.writeable += [path] if value.flags.writeable else []
        elif isinstance(value, OF_KERNELS) or id(value) in self._seen:
            return
        elif isinstance(value, Mapping):
            for key, part in value.items():
                self.look(part, again[key], f"{path}[{key!r}]")
        elif isinstance(value, tuple | list):
            for number, (part, other) in enumerate(zip(value, again, strict=True)):
                self.look(part, other, f"{path}[{number}]")
        elif type(value).__module__.startswith("cpr_core."):
            self._seen[id(value)] = value
            self.kinds.add(type(value))
            for name in self._attributes(value):
                self.look(getattr(value, name), getattr(again, name), f"{path}.{name}")

    def _attributes(self, value):
        for name in dir(value):
            member = inspect.getattr_static(type(value), name, None)
            method = inspect.isfunction(member) or isinstance(member, classmethod | staticmethod)
            if not method and not name.startswith("_") and name not in NAMES_OF_KERNELS:
                yield name


def signatures_of_kernels():
    """For what types every kernel is compiled or loaded in this process."""
    kernels = {
        kernel
        for name, module in list(sys.modules.items())
        if name.startswith("cpr_core.")
        for kernel in vars(module).values()
        if isinstance(kernel, Dispatcher)
    }
    assert len(kernels) > 100
    # The string of a tuple would hide it: it has the representations of its types.
    return {k: {", ".join(map(str, types)) for types in k.signatures} for k in kernels}


def compiled_twice(before):
    """Kernels made since then for arrays that are read-only beside the same that are not.

    Args:
        before: Of `signatures_of_kernels`: other tests may hand kernels what they like.
    """
    twice = []
    for kernel, types in signatures_of_kernels().items():
        alike = [found.replace("readonly ", "") for found in types]
        made = types - before.get(kernel, set())
        if any(alike.count(found.replace("readonly ", "")) > 1 for found in made):
            twice.append(kernel)
    return twice


def test_so_are_all_arrays_of_answers():
    """Some were changed in place, and what was asked again of the same answer was that.

    Arrays made anew whenever they are asked for may be written to: nothing else changes by that.
    """
    walk, before = Walk(), signatures_of_kernels()
    for name in ("rfrfr", "six_rfs", "planar_body"):
        for found in answers(name):
            walk.look(found, found, f"{name}: {type(found).__name__}")
    found = small_map()
    pressed = critical_load(solve_home(found.robot), [0.0, -1.0, 0.0])
    for answer in (found, summary_of(found, 1e-4), pressed):
        walk.look(answer, answer, type(answer).__name__)
    assert walk.writeable == []
    assert walk.kept > 300
    assert walk.kinds >= ANSWERS
    assert compiled_twice(before) == []


def test_a_robot_that_was_written_to_would_answer_otherwise():
    robot = load_robot("rfrfr")
    with pytest.raises(ValueError, match="read-only"):
        robot.unit_motions[...] = 0.0
    found = solve_forward(robot, solve_home(robot).motors + 0.2)
    assert found.margin > 0.0
    assert found.spectrum_locked.eigenvalues[0] > 0.0


def test_how_often_newton_stepped_is_told_of_one_equilibrium_alone():
    home = solve_home(load_robot("rfrfr"))
    steps = home.iterations
    assert home.with_iterations(steps + 7).iterations == steps + 7
    assert home.iterations == steps
