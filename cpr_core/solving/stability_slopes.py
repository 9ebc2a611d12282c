# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How stability changes with numbers of the description, along the way the equilibrium takes."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ..description.inherited_loads import inherited_loads
from ..description.parameters import Parameter
from ..model.displacement import displaced
from ..model.equilibrium import Equilibrium
from ..model.equilibrium_steps import equilibrium_at
from ..model.model_state import configuration_of
from ..model.nearby_robots import FOURTH_ORDER, Nearby, nearby
from ..model.residual_rates import parameter_scales, small_change
from ..model.robot import Robot, kept_with_robot
from ..model.softest_motion import SizeOfMotion, SoftestMotion, softest_motion

__all__ = ["stability_slopes"]

Floats = NDArray[np.float64]

_SIZES: dict[str, SizeOfMotion] = {"margin": "elastic", "smallest_eigenvalue": "unit"}
#: Step in natural units of the parameter and of the state, or as many sizes of the parameter: whichever
#: is smaller; but no less than a part of the former, for rounding.
_STEP, _OWN, _LEAST = 2e-3, 5.0, 1e-4
#: Slopes of the motions of one eigenvalue nearer to each other than this part of them are the same, or
#: nearer than this part of the eigenvalue by a natural unit of the parameter.
_SAME, _ROUNDING = 1e-5, 1e-8


def stability_slopes(
    equilibrium: Equilibrium,
    parameters: Sequence[Parameter],
    states: Floats,
    wanted: Collection[str],
) -> dict[str, Floats]:
    """Derivatives of margin and smallest eigenvalue, (P,) each; (0,) where not wanted.

    Where there is no margin, as some motion costs no elastic energy, it has no derivatives: NaN. Nor has
    an eigenvalue of several motions by a parameter that parts it: it falls wherever that goes.

    Differences along the straight way ``state + dx``, ``parameter + dp``, which leaves the true one in
    second order only; of what the eigenvector of now makes of K and M there, which is smooth where
    eigenvalues are close together, too.

    Args:
        equilibrium: Where.
        parameters: Numbers of its description.
        states: Derivatives of the state by them, (N, P), platform rows world twists.
        wanted: Names of quantities.
    """
    found = {name: np.zeros(len(parameters) if name in wanted else 0) for name in _SIZES}
    motions = {}
    for name in _SIZES:
        if name in wanted:
            motion = _motion(equilibrium, name)
            if motion is None:
                found[name][:] = math.nan
            else:
                motions[name] = motion
    if not motions:
        return found
    scales = parameter_scales(equilibrium, parameters)
    sizes = np.array([parameter.size for parameter in parameters])
    small = small_change(scales, sizes, _OWN, _LEAST)
    for column, (parameter, natural, most) in enumerate(
        zip(parameters, scales.tolist(), small.tolist(), strict=True)
    ):
        rate = states[:, column]
        if natural == 0.0:
            continue
        response = float(np.abs(rate / equilibrium.robot.kernel_arrays.unit).max())
        step = _STEP * min(most, 1.0 / max(response, 1e-300))
        near = _near(equilibrium.robot, parameter, 2.0 ** math.floor(math.log2(step)))
        beside = [
            _moved(equilibrium, robot, change * rate)
            for robot, change in zip(near.robots, near.changes, strict=True)
        ]
        for name, motion in motions.items():
            changes = [motion.change(each) for each in beside]
            slope = np.tensordot(near.weights, changes, axes=1)
            rounding = _ROUNDING * abs(motion.eigenvalue) / natural
            found[name][column] = _common_slope(slope, rounding)
    return found


def _common_slope(slopes: Floats, rounding: float) -> float:
    """The slope of an eigenvalue whose motions have these, (K, K); NaN: it parts into several."""
    values = np.linalg.eigvalsh(slopes)
    same = values[-1] - values[0] <= max(rounding, _SAME * np.abs(values).max())
    return float(values.mean()) if same else math.nan


def _motion(equilibrium: Equilibrium, name: str) -> SoftestMotion | None:
    """That of a quantity; rounding says where there is no margin which motion it would be of."""
    if name == "margin" and math.isnan(equilibrium.margin):
        return None
    return softest_motion(equilibrium, _SIZES[name])


def _near(robot: Robot, parameter: Parameter, step: float) -> Nearby:
    """Robots beside one in a parameter, those of the last step kept: they have memory of their own."""
    last = _last_beside(robot, parameter)
    if not last or last[0][0] != step:
        last[:] = [(step, nearby(robot, parameter, FOURTH_ORDER, step))]
    return last[0][1]


@kept_with_robot
def _last_beside(robot: Robot, parameter: Parameter) -> list[tuple[float, Nearby]]:
    """The step of the last question and the robots there, to be filled."""
    return []


def _moved(equilibrium: Equilibrium, near: Robot, change: Floats) -> Equilibrium:
    """A changed state of another robot, as if it were an equilibrium."""
    robot = equilibrium.robot
    loads = inherited_loads(equilibrium.loads, robot.default_loads, near.default_loads)
    place = displaced(robot, *configuration_of(equilibrium), change)
    return equilibrium_at(near, loads, near.load_arrays(loads), place)
