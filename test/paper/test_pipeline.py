# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The whole reproduction, short form."""

import xml.etree.ElementTree as ElementTree

import pytest

from paper.__main__ import main
from paper.report import FIGURES


@pytest.mark.slow(seconds=60)
def test_a_quick_run_writes_everything_and_shows_what_it_has_to(tmp_path, capsys):
    folder, copy = tmp_path / "results", tmp_path / "copy"
    assert main(["--quick", "--output", str(folder), "--publish", str(copy)]) == 0
    report = (folder / "REPORT.md").read_text()
    for name in FIGURES:
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert ElementTree.parse(folder / f"{name}.svg").getroot().tag.endswith("svg")
        assert f"({name}.png)" in report
        assert (copy / f"{name}.png").exists()
    assert (copy / "REPORT.md").read_text() == report
    assert not list(copy.glob("*.svg"))
    for number in ("i", "ii", "iii", "iv", "v", "vi"):
        assert (folder / f"table_{number}.csv").stat().st_size > 100
        assert f"**Table {number.upper()}.**" in report
    printed = capsys.readouterr().out.splitlines()
    claims = [line for line in printed if line.startswith(("met ", "NOT MET "))]
    not_met = [line for line in claims if line.startswith("NOT MET ")]
    assert len(claims) == 17
    assert all(
        "times faster" in line for line in not_met
    )  # what does not depend on the machine holds
