# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Functions of many lines or parameters say why they are not several."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (
    "cpr_core",
    "cpr_ros",
    "paper",
    "benchmarks",
    "verification",
    "tools",
    "test",
    "examples",
    "launch",
)
#: Lines behind the docstring: what says how a function is used does not make it longer.
MOST_LINES, MOST_PARAMETERS = 60, 8
#: How it is said, in the docstring or a comment: of many lines, at the beginning of a clause;
LONG = re.compile(r"(?:[.;] |\"\"\"|# )[Ll]ong, (?:as|for) ")
#: of many parameters.
TAKES_MUCH = re.compile(
    r"parameters [^.;]*given by name\.|arrays by themselves, as |numbers by themselves, as "
    r"|\. It takes (?:what|all) |is handed on as numbers"
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
        said = " ".join("\n".join(lines[node.lineno : described + 1]).split())
        long = node.end_lineno - described > MOST_LINES and not LONG.search(said)
        if long or (count > MOST_PARAMETERS and not TAKES_MUCH.search(said)):
            found.append(node.name)
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_long_functions_say_why(package):
    files = sorted((ROOT / package).rglob("*.py"))
    assert files
    found = {file: names for file in files if (names := without_reason(file.read_text("utf-8")))}
    assert found == {}


@pytest.mark.parametrize("statements", [MOST_LINES, MOST_LINES + 1])
@pytest.mark.parametrize(
    ("said", "is_reason"),
    [
        ("Add.", False),
        ("Add to what is long, as the rods are.", False),
        ("Add. All parameters are given by name.", False),
        ("Add. Long, as every term has its line.", True),
        ("Long, as every term has its line.", True),
        ("Add; long, for every term has its line.", True),
    ],
)
def test_a_long_function_is_found(statements, said, is_reason):
    body = "\n".join(["    x += 1"] * statements)
    text = f'def longest(x):\n    """{said}"""\n{body}\n'
    expected = ["longest"] if statements > MOST_LINES and not is_reason else []
    assert without_reason(text) == expected


@pytest.mark.parametrize("count", [MOST_PARAMETERS, MOST_PARAMETERS + 1])
@pytest.mark.parametrize(
    ("said", "is_reason"),
    [
        ("Add.", False),
        ("Add. Long, as every term has its line.", False),
        ("Add what is handed on, and robots that are given by name.", False),
        ("Add the forces; it takes what is left, too.", False),
        ("Add. All parameters are options, given by name.", True),
        ("Add. It takes what the others take, and its own.", True),
    ],
)
def test_a_function_that_takes_much_is_found(count, said, is_reason):
    names = ", ".join(f"x{number}" for number in range(count))
    text = f'class Kept:\n    def longest(self, {names}):\n        """{said}"""\n'
    expected = ["longest"] if count > MOST_PARAMETERS and not is_reason else []
    assert without_reason(text) == expected
