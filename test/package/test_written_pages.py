# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Tools that write parts of pages tell of a page that is not current, and leave the rest of it."""

import argparse
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
PAGE = (
    "head\n<!-- rows: written by tools/rows.py, do not edit -->\nold\n<!-- end of rows -->\ntail\n"
)


@pytest.fixture
def tools(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(TOOLS)
    import interface_page
    import marked_section

    monkeypatch.setattr(marked_section, "ROOT", tmp_path)
    monkeypatch.setattr(interface_page, "PAGE", tmp_path / "interface.md")
    (tmp_path / "page.md").write_text(PAGE)
    return marked_section, interface_page


def called(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["tool", *arguments])


def test_a_section_that_is_not_current_is_told_and_then_written(
    tools, monkeypatch, tmp_path, capsys
):
    def keep(*arguments):
        called(monkeypatch, *arguments)
        return tools[0].keep_current("rows.py", "page.md", "rows", lambda: "\nnew | row\n\n")

    assert keep("--check") == 1
    assert "page.md is not current: run tools/rows.py" in capsys.readouterr().err
    assert (tmp_path / "page.md").read_text() == PAGE
    assert keep() == 0
    assert (tmp_path / "page.md").read_text() == PAGE.replace("\nold\n", "\nnew | row\n")
    assert keep("--check") == 0
    (tmp_path / "page.md").write_text("head")
    with pytest.raises(SystemExit, match="no place for the rows"):
        keep()


def test_a_row_is_one_row_whatever_its_cells_say(tools):
    assert tools[0].row("a|b", "c") == r"| a\|b | c |"


def test_the_page_of_interfaces_is_told_to_be_missing_or_not_current(tools, monkeypatch, capsys):
    called(monkeypatch, "--check")
    assert tools[1].main() == 1
    assert "is not current" in capsys.readouterr().err
    called(monkeypatch)
    assert tools[1].main() == 0
    called(monkeypatch, "--check")
    assert tools[1].main() == 0
    tools[1].PAGE.write_text(tools[1].PAGE.read_text() + "\n")
    assert tools[1].main() == 1


def test_an_interface_is_read_as_it_is_written(tools):
    text = """# About
# itself.
int32 RIGHT = 1  # to the right
float64[] motors # where to,
                 # all of them
---
# of the answer
bool done true  # whether | or not
"""
    about, (request, answer) = tools[1].parsed(text, 2)
    assert about == "About itself."
    assert request.constants == [["RIGHT", "1", "to the right"]]
    assert request.fields == [["motors", "float64[]", "", "where to, all of them"]]
    assert answer.fields == [["done", "bool", "true", "whether | or not"]]
    rows = tools[1].table(("field", "type", "default", "meaning"), answer.fields)
    assert rows[-1] == r"| `done` | `bool` | `true` | whether \| or not |"
    rows = tools[1].table(("field", "type", "default", "meaning"), request.fields)
    assert rows[1] == "| field | type | meaning |"


def test_an_option_whose_help_does_not_end_with_its_default_is_an_error(tools):
    import option_section

    parser = argparse.ArgumentParser()
    told = parser.add_argument("--port", type=int, default=80, help="where; default %(default)s")
    assert option_section._cells(told) == ("`--port`", "where", "`80`")
    for help_text in ("where", "where; default %(default)s, or any"):
        wrong = argparse.ArgumentParser().add_argument("--port", default=80, help=help_text)
        with pytest.raises(ValueError, match=r"--port.*does not end with"):
            option_section._cells(wrong)
