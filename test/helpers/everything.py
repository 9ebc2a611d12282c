# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A program that uses every kernel and prints, as JSON, which of them it had to compile."""

EVERYTHING = """
import json
import cpr_core
from cpr_core.kernel_warmup import watch_compilation
from cpr_core.description.description_file import shipped_robots
compiled = []
solvers = {
    "motors": cpr_core.solve_forward,
    "efforts": cpr_core.solve_forward_by_effort,
    "pose": cpr_core.solve_inverse,
}
with watch_compilation(compiled.append):
    for name in shipped_robots():
        robot = cpr_core.load_robot(name)
        home = cpr_core.solve_home(robot)
        for what, solve in solvers.items():
            values = getattr(home, what)
            if len(values):
                assert solve(robot, values, start=home).converged
        assert cpr_core.kinemato_statics(home).smallest_singular_value("forward") > 0.0
        assert home.spectrum_free.eigenvalues.size
        cpr_core.leg_shapes(home)
        cpr_core.bending_strains(home)
        cpr_core.derivatives(home, "legs[0].base.position[0]")
print(json.dumps(compiled))
"""
