# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What README and docs show in Python and for a shell runs as it is, page by page."""

import re
import shlex
from pathlib import Path

import pytest

from cpr_core.command_line import main

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def shell_lines():
    """Words of every line for a shell, of all pages, once."""
    found = {}
    for page in PAGES:
        for block in re.findall(r"```sh\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            for line in block.replace("\\\n", " ").splitlines():
                words = shlex.split(line, comments=True)
                found[" ".join(words)] = words
    return found


COMMANDS = {
    line: words
    for line, words in shell_lines().items()
    if words[:1] == [".venv/bin/cpr"] and words[1] != "view"  # that one does not end
}


#: Run by tests of the node.
OF_THE_NODE = {"node.md", "recording.md"}
PROGRAMS = [page for page in PAGES if "```python" in page.read_text(encoding="utf-8")]


def test_tests_of_the_node_run_pages_that_there_are():
    assert {page.name for page in PROGRAMS} > OF_THE_NODE


@pytest.mark.parametrize(
    "page", [page for page in PROGRAMS if page.name not in OF_THE_NODE], ids=lambda page: page.stem
)
def test_the_programs_of_a_page_run_one_after_the_other(page, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        # A map as fine as on the page takes minutes.
        program = block.replace("resolution=0.01", "resolution=0.1")
        exec(compile(program, str(page), "exec"), names)
    assert capsys.readouterr().out


@pytest.mark.parametrize("line", COMMANDS)
def test_the_commands_of_the_pages_do_something(line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _, *arguments = COMMANDS[line]
    # A map as fine as on the page takes seconds, and says nothing more here.
    coarse = ["0.1" if before == "--resolution" else word for before, word in pairs(arguments)]
    assert main(coarse) == 0
    assert capsys.readouterr().out.strip()
    written = {word for before, word in pairs(arguments) if before in ("--plot", "--out")}
    assert {file.name for file in tmp_path.iterdir()} == written


def test_our_programs_are_called_where_they_are():
    """As `make` installs them, on every page."""
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    blocks = "".join(re.findall(r"```(?:sh|console)\n(.*?)```", text, re.DOTALL))
    called = re.findall(r"^(?:\$ )?(\S*\bcpr(?:_node|_view|_demo)?) ", blocks, re.MULTILINE)
    assert len(called) > 20
    assert {name.rpartition("/")[0] for name in called} == {".venv/bin"}


def pairs(words):
    """Every word with the one before it."""
    return zip(["", *words], words, strict=False)


def test_what_the_pages_want_made_is_a_target_and_every_module_is_there():
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    wanted = {words[1] for words in shell_lines().values() if words[:1] == ["make"] and words[1:]}
    wanted |= set(re.findall(r"`make ([a-z-]+)", text))
    assert {"demo", "test", "paper", "bench", "colcon"} <= wanted <= targets
    modules = set(re.findall(r"python -m ([a-z_.]+[a-z])", text))
    assert len(modules) >= 5
    for module in modules:
        place = ROOT / module.replace(".", "/")
        assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file(), module
