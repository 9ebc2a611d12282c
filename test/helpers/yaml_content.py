# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Content of YAML texts, read once: hundreds of tests begin with that of a shipped robot."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import Any

import yaml

from cpr_core.description.description_file import shipped_robots


def yaml_content(text: str) -> Any:
    """What ``yaml.safe_load`` makes of a text, to be changed at will."""
    return deepcopy(_loaded(text))


def shipped_content(name: str) -> Any:
    """The same of the description of a shipped robot."""
    return yaml_content(shipped_robots()[name].read_text(encoding="utf-8"))


@lru_cache(maxsize=64)
def _loaded(text: str) -> Any:
    return yaml.safe_load(text)
