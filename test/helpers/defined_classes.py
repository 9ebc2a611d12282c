# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""All classes of a package, for tests that are about all of a kind."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import ModuleType


def classes_of(package: ModuleType) -> list[type]:
    """All classes that the modules of a package define, public or not."""
    found = []
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if not module.name.endswith(".__main__"):
            members = vars(importlib.import_module(module.name)).values()
            found += [member for member in members if inspect.isclass(member)]
    own = (kind for kind in found if kind.__module__.startswith(f"{package.__name__}."))
    return list(dict.fromkeys(own))
