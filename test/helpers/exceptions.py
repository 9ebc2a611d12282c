# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Exceptions of a package, and what is left of one elsewhere."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from types import ModuleType
from typing import Any

import numpy as np

from cpr_core import Equilibrium, Robot
from helpers.defined_classes import classes_of


def exceptions_of(package: ModuleType) -> list[type[Exception]]:
    """Those that are raised, and warnings."""
    return [kind for kind in classes_of(package) if issubclass(kind, Exception)]


def example_of(kind: type[Exception], arguments: Mapping[type, tuple[Any, ...]]) -> Exception:
    """An exception, from arguments by the class whose ``__init__`` takes them."""
    owner = next(base for base in kind.__mro__ if "__init__" in vars(base))
    return kind("text") if owner.__module__ == "builtins" else kind(*arguments[owner])


def assert_travels(error: Exception) -> None:
    """Whether copies, and what comes from other processes, are the same."""
    copies = [copy.copy(error), copy.deepcopy(error)]
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        copies.append(pickle.loads(pickle.dumps(error, protocol)))
    for other in copies:
        assert type(other) is type(error)
        assert str(other) == str(error)
        assert other.args == error.args
        np.testing.assert_equal(_plain(vars(other)), _plain(vars(error)))


def _plain(value: Any) -> Any:
    """A value as numbers, names and arrays."""
    if isinstance(value, Robot):
        return value.description.text
    if isinstance(value, Equilibrium):
        return _plain(value.robot), _plain(value.loads), value.record
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: _plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value
