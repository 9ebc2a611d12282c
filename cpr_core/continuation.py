"""From one equilibrium to a requested one, along a straight path in what the request imposes.

The whole way is tried in one step first. A step is accepted only if every Newton correction
contracts, so the solution belongs to the branch of the start; otherwise the step is halved. A request
that cannot be reached this way is an error, never another branch.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .arrays import LoadArrays, workspace
from .equilibrium import RESIDUAL_TOLERANCE, Equilibrium
from .errors import NoSolution
from .lie import rotation_exp, rotation_log
from .loads import Loads
from .newton_kernel import CONVERGED, newton
from .robot import Robot

__all__ = ["Request", "follow"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: A correction must be smaller than this times the one before.
CONTRACTION = 0.5
#: Newton steps of one path step.
ITERATIONS = 12
#: Smallest path step before the path is given up, as a fraction of the way.
SMALLEST_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Request:
    """What a problem imposes.

    Attributes:
        imposed: Motor positions, motor efforts, or the controlled platform coordinates.
        values: Motor positions or efforts, (n,); not used for the platform.
        platform_rotation: Wanted platform rotation, (3, 3); for the platform.
        platform_position: Wanted platform position, (3,); for the platform.
        loads: Wanted loads.
    """

    imposed: Literal["motors", "efforts", "platform"]
    loads: Loads
    values: Floats | None = None
    platform_rotation: Floats | None = None
    platform_position: Floats | None = None


def follow(start: Equilibrium, request: Request) -> Equilibrium:
    """Follow the branch of an equilibrium until a request is met.

    Args:
        start: Equilibrium to start from.
        request: What to impose.

    Returns:
        The equilibrium on the same branch.

    Raises:
        NoSolution: With the fraction of the way and the last equilibrium on it.
    """
    path = _Path(start, request)
    reached, step, here, iterations = 0.0, 1.0, start, 0
    while reached < 1.0:
        target = min(1.0, reached + step)
        result, used = path.step(here, target)
        iterations += used
        if result is None:
            step = 0.5 * (target - reached)
            if step < SMALLEST_STEP:
                raise NoSolution(
                    f"no equilibrium found beyond {reached:.4f} of the way from the start",
                    reached,
                    here,
                )
            continue
        here, step, reached = result, 2.0 * (target - reached), target
    return here if here.iterations == iterations else replace(here, iterations=iterations)


class _Path:
    """The straight path of a request and one solve on it."""

    def __init__(self, start: Equilibrium, request: Request) -> None:
        self.robot: Robot = start.robot
        self.start, self.request = start, request
        robot, arrays = self.robot, self.robot.arrays
        self.loads_change = request.loads is not start.loads
        self.last_loads = (
            robot.load_arrays(request.loads) if self.loads_change else start.load_arrays
        )
        size = len(arrays.unit)
        self.unknowns, self.equations = robot.problems[request.imposed]
        if request.imposed == "platform":
            self.turn = rotation_log(request.platform_rotation @ start.platform_rotation.T)
        self.residual, self.tangent = np.empty(size), np.empty((size, size))
        self.work = workspace(arrays)

    def loads_at(self, fraction: float) -> LoadArrays:
        """Loads part of the way; all entries are linear in what is given."""
        if not self.loads_change or fraction == 1.0:
            return self.last_loads
        pairs = zip(self.start.load_arrays, self.last_loads, strict=True)
        return LoadArrays(*[(1.0 - fraction) * first + fraction * last for first, last in pairs])

    def step(self, here: Equilibrium, fraction: float) -> tuple[Equilibrium | None, int]:
        """Solve at a fraction of the way, starting from an equilibrium before it."""
        robot, start, request = self.robot, self.start, self.request
        motor_index = robot.arrays.motor_index
        state = here.state.copy()
        rotation, position = here.platform_rotation.copy(), here.platform_position.copy()
        effort = np.zeros(robot.motor_count)
        if request.imposed == "motors":
            state[motor_index:] = (1.0 - fraction) * start.motors + fraction * request.values
        elif request.imposed == "efforts":
            effort = (1.0 - fraction) * start.efforts + fraction * request.values
        else:
            axes = robot.controlled_axes
            held = axes[axes >= 3] - 3
            wanted = (
                1.0 - fraction
            ) * start.platform_position + fraction * request.platform_position
            position[held] = wanted[held]
            if np.any(axes < 3):
                rotation = rotation_exp(fraction * self.turn) @ start.platform_rotation
        loads = self.loads_at(fraction)
        status, iterations, largest, energy = newton(
            robot.arrays, loads, state, rotation, position, self.unknowns, self.equations, effort,
            RESIDUAL_TOLERANCE, ITERATIONS, CONTRACTION, self.residual, self.tangent, self.work,
        )  # fmt: skip
        if status != CONVERGED:
            return None, iterations
        return (
            Equilibrium(
                robot=robot,
                loads=request.loads,
                state=state,
                platform_rotation=rotation,
                platform_position=position,
                efforts=self.residual[motor_index:].copy(),
                residual=largest,
                iterations=iterations,
                energy=energy,
                load_arrays=loads,
            ),
            iterations,
        )
