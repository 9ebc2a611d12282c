# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of the library has every public name, and what is to be known of it."""

import ast
import inspect
import re
from enum import Enum
from pathlib import Path

import pytest

import cpr_core
import cpr_core.workspace

PAGE = (Path(__file__).parents[2] / "docs/api.md").read_text(encoding="utf-8")
#: Public names as the page has them.
NAMES = {name: getattr(cpr_core, name) for name in cpr_core.__all__ if name != "__version__"} | {
    f"workspace.{name}": getattr(cpr_core.workspace, name) for name in cpr_core.workspace.__all__
}
ERRORS = {
    name: kind
    for name, kind in NAMES.items()
    if inspect.isclass(kind) and issubclass(kind, Exception | Warning)
}
ENUMERATIONS = {
    name: kind for name, kind in NAMES.items() if inspect.isclass(kind) and issubclass(kind, Enum)
}


def kept_by(kind):
    """Attributes that a class gives its instances."""
    tree = ast.parse(inspect.getsource(kind).strip())
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and ast.unparse(node.value) == "self"
    }


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_on_the_page_once(name):
    entry = rf"^\| `{re.escape(name)}` \|" if name in ERRORS else rf"^\*\*`{re.escape(name)}[`(]"
    assert len(re.findall(entry, PAGE, re.MULTILINE)) == 1


@pytest.mark.parametrize("name", ERRORS)
def test_what_an_error_carries_is_on_the_page(name):
    kept = kept_by(ERRORS[name])
    listed = re.findall(rf"^\| `{name}\.(\w+)` \| \S.* \|$", PAGE, re.MULTILINE)
    assert {*listed} - {"code"} == kept


def test_some_errors_carry_something():
    assert kept_by(cpr_core.NotReached) == {"fraction", "last", "event"}


@pytest.mark.parametrize("name", ENUMERATIONS)
def test_members_of_enumerations_are_on_the_page(name):
    part = PAGE.partition(f"**`{name}`**")[2].partition("\n**`")[0]
    listed = re.findall(r"^\| `(\w+)` \| `(\d+)` \|", part, re.MULTILINE)
    assert listed == [(member.name, str(member.value)) for member in ENUMERATIONS[name]]
    assert listed


RAISING = {
    name: member
    for name, member in NAMES.items()
    if inspect.isfunction(member) and "Raises:" in (inspect.getdoc(member) or "")
}


@pytest.mark.parametrize("name", RAISING)
def test_what_a_function_raises_is_on_the_page(name):
    part = PAGE.partition(f"**`{name}(")[2].partition("\n**`")[0]
    [listed] = re.findall(r"^\| raises \| (.*) \|$", part, re.MULTILINE)
    raised = re.findall(r"`(\w+)`", listed)
    assert len(set(raised)) == len(raised)
    section = inspect.getdoc(RAISING[name]).partition("Raises:\n")[2].partition("\n\n")[0]
    words = re.findall(r"\w+", section)
    assert {word for word in words if word in ERRORS} <= {*raised} <= {*words}


def test_functions_raise_something():
    assert len(RAISING) > 20
    part = PAGE.partition("**`critical_load(")[2].partition("\n**`")[0]
    assert "| raises | `InvalidRequest`, `MotorLimitExceeded`, `StrainLimitExceeded`, " in part


def test_no_markup_of_docstrings_is_on_the_page():
    assert re.findall(r":\w+:`", PAGE) == []
