# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One parameter of every kind that the description of a robot has."""

import re

import numpy as np

from cpr_core.description.description_paths import numbers_in

#: What does nothing to an equilibrium, or says how many there are of something.
IDLE = re.compile(r"(^|\.)(strain|home|limits|inertia|yield_strain|stations)\b")


def parameter_kinds(robot):
    """Paths: of every field the entry that is least like the others, of one leg of each sort."""
    written = robot.description.written
    known = dict.fromkeys(path for path, _ in numbers_in(written.content))
    for name, value in written.read.items():
        known |= dict.fromkeys(path for path, _ in numbers_in(value, name))
    kinds = {}
    for path in known:
        if not IDLE.search(path):
            kinds.setdefault(re.sub(r"^legs\[\d+\]", "legs[]", path), path)
    return [path for path in kinds.values() if np.isfinite(_value(robot, path))]


def with_loads(robot):
    """A robot under gravity and a force, in which masses and forces do something."""
    force = 0.3 * robot.kernel_arrays.energy_unit / robot.mean_length**2
    values = {"loads.platform_force[0]": force, "loads.platform_force[1]": -0.5 * force}
    if not robot.description.gravity.any():
        values |= {"gravity[1]": -1.0, "platform.mass": force}
    return robot.with_parameters(values)


def _value(robot, path):
    try:
        return robot.parameter_values(path)[0]
    except ValueError:
        return np.nan
