# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What tests share is in one place: no test imports from another, nor from the documentation."""

import ast
from pathlib import Path

from helpers.import_statements import import_statements

TESTS = Path(__file__).parents[1]


def imported(path):
    """First names of the modules that a file imports, anywhere in it."""
    for node in import_statements(path.read_text()):
        if isinstance(node, ast.Import):
            yield from (name.name.partition(".")[0] for name in node.names)
        else:
            yield "" if node.level else (node.module or "").partition(".")[0]


def test_tests_import_from_helpers_only():
    files = set(TESTS.rglob("*.py"))
    documents = set((TESTS.parent / "docs").rglob("*.py"))
    helpers = {path for path in files if path.parent.name == "helpers"}
    assert len(helpers) > 5
    forbidden = {path.stem for path in (files - helpers) | documents} | {""}
    wrong = [(path.name, name) for path in files for name in imported(path) if name in forbidden]
    assert wrong == []
    assert any("helpers" in imported(path) for path in files - helpers)
