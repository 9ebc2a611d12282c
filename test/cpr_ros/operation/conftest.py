# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Sessions that tests move, and where the last state of a robot is kept."""

import pytest
from helpers.session_bench import Bench


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def node():
    """At rest, where any first step has been judged."""
    bench = Bench()
    bench.session.commands.place(bench.session.solver.current.equilibrium.motors)
    bench.rest()
    return bench


@pytest.fixture
def file(tmp_path):
    """Of the last state; nobody has made its folder."""
    return tmp_path / "folder" / "node.state"
