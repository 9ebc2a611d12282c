# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a reference model must not use: it is to agree with the library, not to be it."""

from __future__ import annotations

import ast
from pathlib import Path
from types import ModuleType

from cpr_core.kernels.kernel_sources import kernel_modules, read_sources
from helpers.import_statements import import_statements

#: Modules of the strain-mode model beside its kernels.
_MODEL = {"model", "stability", "shape", "kinemato_statics"}


def imported_kernels(module: ModuleType) -> set[str]:
    """Kernels and parts of the strain-mode model that a module imports."""
    assert module.__file__ is not None
    imported = {
        (node.module or "").rpartition(".")[2]
        for node in import_statements(Path(module.__file__).read_text())
        if isinstance(node, ast.ImportFrom)
    }
    kernels = {name.rpartition(".")[2] for name in kernel_modules(read_sources())}
    return imported & ({*kernels, *_MODEL} - {"lie"})
