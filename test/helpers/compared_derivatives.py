# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Derivatives by parameters beside full solves of robots with other parameters."""

import numpy as np

from cpr_core import derivatives, load_robot, solve_forward, solve_home
from cpr_core.description.changed_description import named_parameters
from cpr_core.model.residual_rates import parameter_scales
from helpers.parameter_kinds import with_loads
from helpers.shipped_steps import REDUNDANT, STEPS
from helpers.solved_beside import polished, robots_beside, solved_slopes

STATE = ("position", "rotation", "motors", "efforts")
#: Steps of the solves compared with, in parts of what moves the robot by a natural unit.
STEPS_TRIED = (1e-3, 1e-4)


def equilibrium_of(name):
    robot = with_loads(load_robot(name))
    found = solve_forward(robot, solve_home(robot).motors + np.array(STEPS[name]))
    return polished(found, "motors")


def problems_of(name):
    return ("motors", "efforts") if name in REDUNDANT else ("motors", "pose", "efforts")


def natural_units(robot):
    energy = robot.kernel_arrays.energy_unit
    return {
        "position": robot.mean_length,
        "rotation": 1.0,
        "motors": robot.motor_units,
        "efforts": energy / robot.motor_units,
        "margin": 1.0,
        "smallest_eigenvalue": energy,
    }


def compared(equilibrium, path, problem, quantities, tolerance=1e-6):
    """Assert that derivatives are those of full solves; whether there were any to compare with.

    Full solves have errors of their own, of fourth order in their steps: one of two has to agree.
    """
    robot, units = equilibrium.robot, natural_units(equilibrium.robot)
    of = ("pose", "motors", "efforts", *(name for name in quantities if name not in STATE))
    found = derivatives(equilibrium, path, of, problem)
    (parameter,) = named_parameters(robot.description, path)
    (scale,) = parameter_scales(equilibrium, (parameter,))
    mine = {name: scale * getattr(found, name)[..., 0] / units[name] for name in quantities}
    if scale == 0.0:
        assert not any(np.any(getattr(found, name)) for name in STATE)
        return False
    moved = max(
        1.0,
        *(
            np.abs(scale * getattr(found, name) / np.reshape(units[name], (-1, 1))).max()
            for name in STATE
        ),
    )
    away = []
    for part in STEPS_TRIED:
        step = part * scale / moved
        robots = robots_beside(robot, parameter, step)
        if robots is None:
            return False
        true = solved_slopes(equilibrium, robots, step, problem)
        away.append(
            max(np.abs(mine[name] - scale * true[name] / units[name]).max() for name in quantities)
        )
        if away[-1] < tolerance * moved:
            return True
    raise AssertionError((path, problem, away, moved))
