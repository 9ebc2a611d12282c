# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Processes that run the code of this tree, whether or not it is installed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

TESTS = Path(__file__).parents[1]
ROOT = TESTS.parent


def finding_this_tree(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """An environment in which Python finds this tree and its helpers before all it found already.

    What colcon has built is found by ``PYTHONPATH``.
    """
    paths = [str(ROOT), str(TESTS), *filter(None, [environment.get("PYTHONPATH")])]
    return dict(environment) | {"PYTHONPATH": os.pathsep.join(paths)}
