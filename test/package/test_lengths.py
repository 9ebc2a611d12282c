# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Functions of many lines or parameters say why they are not several."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("cpr_core", "cpr_ros", "paper", "benchmarks", "verification", "tools")
MOST_LINES, MOST_PARAMETERS = 60, 8
#: How it is said, in the docstring or a comment.
REASON = re.compile(
    r"\b(long, |one function: |given by name|by themselves|it takes what|it takes all|handed on)",
    re.IGNORECASE,
)


def without_reason(text):
    """Names of functions that are long or take much, and do not say why."""
    found = []
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        described = node.body[0].end_lineno if ast.get_docstring(node) else node.body[0].lineno - 1
        taken = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        count = len([argument for argument in taken if argument.arg not in ("self", "cls")])
        said = "\n".join(lines[node.lineno : described + 1])
        much = node.end_lineno - described > MOST_LINES or count > MOST_PARAMETERS
        if much and not REASON.search(" ".join(said.split())):
            found.append(node.name)
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_long_functions_say_why(package):
    files = sorted((ROOT / package).rglob("*.py"))
    assert files
    found = {file: names for file in files if (names := without_reason(file.read_text("utf-8")))}
    assert found == {}


@pytest.mark.parametrize("statements", [MOST_LINES, MOST_LINES + 1])
@pytest.mark.parametrize("reason", ["", " Long, as every term has its line."])
def test_a_long_function_is_found(statements, reason):
    body = "\n".join(["    x += 1"] * statements)
    text = f'def longest(x):\n    """Add.{reason}"""\n{body}\n'
    expected = ["longest"] if statements > MOST_LINES and not reason else []
    assert without_reason(text) == expected


@pytest.mark.parametrize("count", [MOST_PARAMETERS, MOST_PARAMETERS + 1])
def test_a_function_that_takes_much_is_found(count):
    names = ", ".join(f"x{number}" for number in range(count))
    text = f"class Kept:\n    def longest(self, {names}):\n        pass\n"
    assert without_reason(text) == (["longest"] if count > MOST_PARAMETERS else [])
