# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Imports of a source, wherever they are."""

import ast

#: Fields that hold statements, or what holds statements itself.
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")


def import_statements(source):
    """Every import of a source, also inside functions; expressions, which have none, are left out."""
    waiting = [ast.parse(source)]
    for node in waiting:
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        waiting += [inner for block in _BLOCKS for inner in getattr(node, block, ())]
