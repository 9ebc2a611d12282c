# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A node that is configured has everything it needs: no request waits for an import."""

import json
import subprocess
import sys

from helpers.quick_end import QUICK_END

#: Refused walks, a halt, the response without condensed legs: what is imported for them is told.
REQUESTS = """
import contextlib, json, sys
import numpy as np
import cpr_ros
from cpr_core import CprError, estimate_wrench, kinemato_statics, load_robot, solve_forward
from cpr_core import solve_forward_by_effort, solve_inverse
from cpr_ros.messages.frames import Frames
from cpr_ros.settings.parameter_table import PARAMETERS
from cpr_ros.settings.node_settings import Parameters, live_parameters
from cpr_ros.operation.session import Session
from cpr_ros.warming import warm_up

defaults = {parameter.name: parameter.default for parameter in PARAMETERS}
fixed = {parameter.name: parameter.default for parameter in PARAMETERS if not parameter.live}
parameters = Parameters(**fixed | {"characteristic_length": None})
frames, live = Frames("base", "platform"), live_parameters(defaults.__getitem__)
requests = 0
for name in ("rfrfr", "delta"):
    robot = load_robot(name)
    session = Session(robot, frames, parameters, live)
    steps = list(warm_up(session, frames))
    before = set(sys.modules)
    home = session.solver.current.equilibrium
    for request in (
        lambda: solve_inverse(robot, home.pose + 5.0, start=home),
        lambda: solve_forward(robot, home.motors + [4.0, -4.0, 0.0][: len(home.motors)], start=home),
        lambda: solve_forward_by_effort(robot, home.efforts + 10.0, start=home),
        lambda: kinemato_statics(home).smallest_singular_value("inverse"),
        lambda: home.margin,
        lambda: estimate_wrench(
            robot,
            home.motors,
            efforts=home.efforts,
            effort_deviation=0.01,
            pose=[*home.platform_position, *home.platform_quaternion],
            pose_deviation=(1e-3, 1e-2),
        ).consistency,
    ):
        with contextlib.suppress(CprError):
            request()
        requests += 1
    new = sorted(module for module in set(sys.modules) - before if not module.startswith("cpr_"))
    print(json.dumps([requests, new]))
"""


def test_no_request_waits_for_an_import():
    done = subprocess.run(
        [sys.executable, "-c", QUICK_END + REQUESTS],
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert answers == [[6, []], [12, []]]
