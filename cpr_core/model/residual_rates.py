# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""How the residual of the model changes with numbers of the description, the state held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..description.loads import Loads
from ..description.parameters import Parameter
from ..kernels.prepared_robot import evaluate_prepared
from .array_rates import ArrayRates, VariedArrays, load_rates, robot_rates, varied_loads
from .equilibrium import Equilibrium

__all__ = ["ResidualRates", "parameter_scale", "residual_rates"]

Floats = NDArray[np.float64]

#: Step of central differences, in what changes the residual of a bent state by one natural unit.
_STEP = 1e-5
#: How far a state is bent where a parameter is tried, in natural units.
_BENT = 0.3
#: Second differences below this, over first ones, are rounding: the residual is linear.
_LINEAR = 1e-12


@dataclass(frozen=True, eq=False)
class ResidualRates:
    """Derivatives of the model at an equilibrium, in the state order of the robot, SI units.

    Attributes:
        tangent: Of the residual by the state, (N, N), world rotations of the platform.
        rates: Of the residual by the parameters, (N, P); motor rows are those of efforts.
    """

    tangent: Floats
    rates: Floats


class _Variation(NamedTuple):
    """How a parameter is varied.

    Attributes:
        own: What changes in the arrays of the robot.
        outer: What changes in those of the loads.
        size: What changes the residual of a bent state by about a natural unit; 0 where nothing does.
        linear: Whether the residual is linear in it.
    """

    own: tuple[ArrayRates, ...]
    outer: tuple[ArrayRates, ...]
    size: float
    linear: bool


def residual_rates(equilibrium: Equilibrium, parameters: Sequence[Parameter]) -> ResidualRates:
    """Derivatives of the residual by parameters.

    Central differences; where the residual is linear in a parameter a single one, exact.

    Args:
        equilibrium: Where.
        parameters: Of its robot.

    Raises:
        InvalidRequest: A number that is not given, or that says how many there are of something.
        DescriptionError: No robot is near this one in a number.
    """
    model = _Model(equilibrium, equilibrium.state)
    middle = model.residual((), (), 0.0).copy()
    tangent = model.tangent.copy()
    rates = np.zeros((len(middle), len(parameters)))
    for column, parameter in enumerate(parameters):
        own, outer, size, linear = _variation(equilibrium, parameter)
        if linear and size:
            rates[:, column] = (model.residual(own, outer, size) - middle) / size
        elif size:
            step = _STEP * size
            ahead = model.residual(own, outer, step).copy()
            rates[:, column] = (ahead - model.residual(own, outer, -step)) / (2.0 * step)
    return ResidualRates(tangent, rates)


def parameter_scale(equilibrium: Equilibrium, parameter: Parameter) -> float:
    """Change of a parameter that means as much as a natural unit; 0 where it means nothing."""
    return _variation(equilibrium, parameter).size


def _variation(equilibrium: Equilibrium, parameter: Parameter) -> _Variation:
    """How a parameter is varied: found once for a robot and loads, the last ones kept."""
    name = f"variation of {parameter.path}"
    last: list[tuple[Loads, _Variation]] = equilibrium.robot.kept(name, list)
    if not last or last[0][0] is not equilibrium.loads:
        last[:] = [(equilibrium.loads, _found_variation(equilibrium, parameter))]
    return last[0][1]


def _found_variation(equilibrium: Equilibrium, parameter: Parameter) -> _Variation:
    """How a parameter is varied, tried at a bent state."""
    robot, arrays = equilibrium.robot, equilibrium.robot.arrays
    own = robot_rates(robot, parameter)
    outer = load_rates(robot, equilibrium.loads, parameter)
    none = _Variation(own, outer, 0.0, True)
    if not own and not outer:
        return none
    # Bent, under forces: in a state without, a parameter may look as if it did nothing.
    count = np.arange(robot.state_size)
    pattern = np.cos(1.0 + 2.3 * count) * (count < arrays.platform_index)
    model = _Model(equilibrium, equilibrium.state + _BENT * arrays.unit * pattern)
    natural = arrays.unit / arrays.energy_unit
    middle = natural * model.residual((), (), 0.0)
    step = _STEP * (parameter.size or 1.0)
    for _ in range(2):  # the first guess may be far off where the parameter is next to zero
        ahead = model.residual(own, outer, step).copy()
        change = natural * (ahead - model.residual(own, outer, -step))
        response = float(np.abs(change).max()) / (2.0 * step)
        if not response > 0.0:
            return none
        step = _STEP / response
    size = 1.0 / response
    ahead = natural * model.residual(own, outer, size)
    behind = natural * model.residual(own, outer, -size)
    second = float(np.abs(ahead + behind - 2.0 * middle).max())
    return _Variation(own, outer, size, second < _LINEAR * max(1.0, np.abs(middle).max()))


class _Model:
    """Residuals at one state of robots beside one."""

    def __init__(self, equilibrium: Equilibrium, state: Floats) -> None:
        self._varied = VariedArrays.of(equilibrium.robot)
        self._loads = equilibrium.load_arrays
        # Copies: read-only arrays are another type to numba, for which it would compile all again.
        self._state = state.copy()
        self._rotation = equilibrium.platform_rotation.copy()
        self._position = equilibrium.platform_position.copy()
        self._residual = np.empty(len(state))
        self.tangent = np.zeros((len(state), len(state)))

    def residual(
        self, own: tuple[ArrayRates, ...], outer: tuple[ArrayRates, ...], change: float
    ) -> Floats:
        """Residual with a change of a parameter, (N,): memory that the next call writes to."""
        varied = self._varied
        loads = varied_loads(self._loads, outer, change)
        before = varied.add(own, change)
        try:
            evaluate_prepared(
                varied.prepared,
                loads,
                self._state,
                self._rotation,
                self._position,
                self._residual,
                self.tangent,
            )
        finally:
            varied.restore(own, before)
        return self._residual
