# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Compiling and importing everything a client could ask for before it asks."""

from __future__ import annotations

import importlib
from collections.abc import Iterator

from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage

from cpr_core import estimate_wrench, solve_forward, solve_forward_by_effort, solve_inverse
from cpr_core.drawing.robot_lines import equilibrium_lines

from .messages.equilibrium_messages import fill_equilibrium
from .messages.frames import Frames
from .messages.stability_stream import Moment, StabilityStream
from .operation.session import Session

__all__ = ["USED_LATER", "warm_up"]

#: The library imports them when they are used first; on a busy machine a request cannot wait for that.
USED_LATER = ("scipy.linalg", "scipy.optimize", "scipy.special")


def warm_up(session: Session, frames: Frames) -> Iterator[str]:
    """Do one of everything at home; yields the name of each step when it is done."""
    for module in USED_LATER:
        importlib.import_module(module)
    robot, home = session.robot, session.solver.current.equilibrium
    solve_forward(robot, home.motors, start=home)
    solve_forward_by_effort(robot, home.efforts, start=home)
    yield "forward problems"
    if robot.description.controlled:
        solve_inverse(robot, home.pose, start=home)
        yield "inverse problem"
    fill_equilibrium(EquilibriumMessage(), home, frames, Time(), 0.0, eigenvalues=True)
    StabilityStream().message(
        Moment(session.present.outcome, 0.0, (0, 0)),
        session.follower.settings.thresholds,
        frames,
        setpoint_age=-1.0,
        wrench_age=-1.0,
    )
    yield "stability and kinemato-statics"
    estimate_wrench(robot, home.motors, efforts=home.efforts, effort_deviation=1.0, start=home)
    equilibrium_lines(home)
    yield "shapes"
