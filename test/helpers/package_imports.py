# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Imports of modules of ours by others, resolved to the modules that are meant."""

import ast
from pathlib import Path
from typing import NamedTuple

from helpers.import_statements import import_statements

PACKAGES = ("cpr_core", "cpr_ros", "paper", "benchmarks", "verification")


class Import(NamedTuple):
    """One name that a module takes from another.

    Attributes:
        importer: The module that imports.
        imported: The module it is taken from.
        name: The name; empty where it is the module itself.
        bound: What it is called in the module that imports it.
        place: File and line.
    """

    importer: str
    imported: str
    name: str
    bound: str
    place: str


def modules_of(root: Path) -> dict[str, Path]:
    """Files of our packages below a folder, by module."""
    found = {}
    for package in PACKAGES:
        for file in sorted((root / package).rglob("*.py")):
            name = ".".join(file.relative_to(root).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = file
    return found


def imports_of(root: Path) -> list[Import]:
    """Every name that a module of ours takes from another, also inside functions and for types."""
    modules, found = modules_of(root), []
    for importer, file in modules.items():
        package = importer if file.name == "__init__.py" else importer.rpartition(".")[0]
        for node in import_statements(file.read_text()):
            if isinstance(node, ast.Import):
                taken = [(alias.name, "", alias.asname or alias.name) for alias in node.names]
            else:
                above = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*(above if node.level else []), *filter(None, [node.module])])
                taken = []
                for alias in node.names:
                    # A name imported from a package is a module of it, or the package's own.
                    inner, bound = f"{base}.{alias.name}", alias.asname or alias.name
                    taken.append(
                        (inner, "", bound) if inner in modules else (base, alias.name, bound)
                    )
            place = f"{file.relative_to(root)}:{node.lineno}"
            found += [Import(importer, *name, place) for name in taken if name[0] in modules]
    return [line for line in found if line.importer != line.imported]
