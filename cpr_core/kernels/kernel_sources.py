# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Which sources kernels are made from: found by what they import, wherever they are.

Kernels are what the decorators of a module make: those of the library, or those of its references.
Machine code is made from the modules with kernels, from what these import (other kernels, constants that
are frozen in it, the way of compiling), and for the values that kernels are given: named tuples of
modules beside them, in the same folder.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Mapping
from pathlib import Path

__all__ = ["KERNEL_DECORATORS", "kernel_modules", "kernel_sources", "read_sources", "stamp_of"]

#: The module whose decorators make the kernels of the library.
KERNEL_DECORATORS = "kernel_decorators"

#: Folder of the package.
FOLDER = Path(__file__).parents[__name__.count(".") - 1]

# Every pattern begins with letters to look for, which is what makes it fast.
_DECORATORS = r"\nfrom \.[\w.]*\b{} import"
_LANES = re.compile(rb"\nfrom \.[\w.]*\blanes import")
#: Dots, module, and names in parentheses or without.
_IMPORT = re.compile(rb"from \.(\.*)([\w.]*) import (?:\(([^)]*)\)|([^\n]*))")
_FOR_ANNOTATIONS = re.compile(rb"if TYPE_CHECKING:\n(?:[ ]+[^\n]*\n|\n)*")
_COMMENT = re.compile(rb"#[^\n]*")


def read_sources(folder: str | Path = FOLDER) -> dict[str, bytes]:
    """Every source below a package's folder, by module; a package's own is called like the package."""
    sources = {}
    for where, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name != "__pycache__"]
        place = os.path.relpath(where, folder).replace(os.sep, ".")
        for name in files:
            if name.endswith(".py"):
                with open(os.path.join(where, name), "rb") as file:  # noqa: PTH118, PTH123
                    sources[f"{place}.{name[:-3]}".removesuffix(".__init__").lstrip(".")] = (
                        file.read()
                    )
    return sources


def kernel_modules(sources: Mapping[str, bytes], decorators: str = KERNEL_DECORATORS) -> list[str]:
    """Modules that define kernels by the decorators of a module of that name."""
    imported = re.compile(_DECORATORS.format(decorators).encode())
    return sorted(module for module, source in sources.items() if imported.search(source))


def kernel_sources(sources: Mapping[str, bytes], decorators: str = KERNEL_DECORATORS) -> list[str]:
    """Modules on which the machine code of these kernels depends."""
    kernels = kernel_modules(sources, decorators)
    folders = {module.rpartition(".")[0] for module in kernels}
    values = {
        module
        for module, source in sources.items()
        if module.rpartition(".")[0] in folders and b"(NamedTuple):" in source
    }
    # Of values only the layout counts; where it is of lanes, it is made of other modules' too.
    waiting = [*kernels, *(module for module in values if _LANES.search(sources[module]))]
    found = set[str]()
    while waiting:
        module = waiting.pop()
        if module not in found:
            found.add(module)
            waiting += _imported(module, sources)
    return sorted(found | values)


def stamp_of(sources: Mapping[str, bytes], decorators: str = KERNEL_DECORATORS) -> tuple[str, int]:
    """Fingerprint of all sources of these kernels and their size, as numba stamps a source."""
    digest, size = hashlib.sha256(), 0
    for module in kernel_sources(sources, decorators):
        digest.update(sources[module])
        size += len(sources[module])
    return digest.hexdigest(), size


def _imported(module: str, sources: Mapping[str, bytes]) -> set[str]:
    """Modules of the package that a module imports, but for annotations only."""
    is_package = any(other.startswith(f"{module}.") for other in sources)
    package = module.split(".") if is_package else module.split(".")[:-1]
    found = set[str]()
    for dots, path, inside, line in _IMPORT.findall(_FOR_ANNOTATIONS.sub(b"", sources[module])):
        parent = package[: len(package) - len(dots)] + path.decode().split(".")
        origin = ".".join(filter(None, parent))
        for text in _COMMENT.sub(b"", inside or line).split(b","):
            name = text.partition(b" as ")[0].strip().decode()
            submodule = f"{origin}.{name}".lstrip(".")
            found.add(submodule if submodule in sources else origin)
    return found & sources.keys()
