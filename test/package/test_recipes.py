# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What README and docs show in Python runs as it is, page by page."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("page", ["README.md", "docs/api.md", "docs/paths.md", "docs/stability.md"])
def test_the_programs_of_a_page_run_one_after_the_other(page, capsys):
    blocks = re.findall(
        r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL
    )
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    assert capsys.readouterr().out
