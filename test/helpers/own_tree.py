# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Processes that tests start run the code of this tree, whatever is installed."""

from __future__ import annotations

import os
from pathlib import Path

TESTS = Path(__file__).parents[1]
ROOT = TESTS.parent


def find_this_tree() -> None:
    """From now on processes find this tree and the helpers first, and then what they found before.

    colcon's ``PYTHONPATH`` leads to what it has built: to a copy of this tree, whose kernels nobody has
    compiled, and to the interface package.
    """
    before = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    own = [str(ROOT), str(TESTS)]
    rest = [path for path in before if path and path not in own]
    os.environ["PYTHONPATH"] = os.pathsep.join([*own, *rest])
