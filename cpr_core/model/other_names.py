# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What other libraries call methods and attributes, and where this one has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

__all__ = ["OF_EQUILIBRIA", "OF_ROBOTS", "OtherNames"]

#: Names that people look for at a robot, and what there is, as expressions.
OF_ROBOTS = {
    "dof": "robot.motor_count",
    "draw": "cpr_core.view(robot)",
    "fk": "cpr_core.solve_forward(robot, motors)",
    "forward": "cpr_core.solve_forward(robot, motors)",
    "gravity": "robot.default_loads.gravity",
    "home": "cpr_core.solve_home(robot)",
    "ik": "cpr_core.solve_inverse(robot, pose)",
    "inverse": "cpr_core.solve_inverse(robot, pose)",
    "jacobian": "cpr_core.solve_forward(robot, motors).jacobian",
    "legs": "robot.description.legs",
    "loads": "robot.default_loads",
    "name": "robot.description.name",
    "plot": "cpr_core.view(robot)",
    "solve": "cpr_core.solve_forward(robot, motors)",
    "view": "cpr_core.view(robot)",
}
#: The same of an equilibrium.
OF_EQUILIBRIA = {
    "T": "(equilibrium.platform_rotation, equilibrium.platform_position)",
    "compliance": "cpr_core.kinemato_statics(equilibrium).compliance()",
    "eigenvalues": "equilibrium.spectrum_locked.eigenvalues",
    "error": "cpr_core.error_of(equilibrium)",
    "forces": "equilibrium.efforts",
    "orientation": "equilibrium.platform_quaternion",
    "position": "equilibrium.platform_position",
    "q": "equilibrium.motors",
    "quaternion": "equilibrium.platform_quaternion",
    "rotation": "equilibrium.platform_rotation",
    "shape": "cpr_core.leg_shapes(equilibrium)",
    "shapes": "cpr_core.leg_shapes(equilibrium)",
    "stiffness": "cpr_core.kinemato_statics(equilibrium).stiffness()",
    "strain": "equilibrium.leg_coordinates",
    "tau": "equilibrium.efforts",
    "torques": "equilibrium.efforts",
    "transform": "(equilibrium.platform_rotation, equilibrium.platform_position)",
}


class OtherNames:
    """Tells where what is looked for is, in place of only that it is not here."""

    _other_names: ClassVar[Mapping[str, str]] = {}

    if not TYPE_CHECKING:  # to a type checker there would be every name

        def __getattr__(self, name: str) -> NoReturn:
            raise _missing(self, name)


def _missing(owner: Any, name: str) -> AttributeError:
    kind = type(owner).__name__
    there = owner._other_names.get(name)
    hint = f"; there is {there}" if there else ""
    return AttributeError(f"{kind!r} object has no attribute {name!r}{hint}", name=name, obj=owner)
