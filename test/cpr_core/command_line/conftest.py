# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command line in this process, by what is asked of it."""

import json

import pytest

from cpr_core.command_line import main


@pytest.fixture
def cpr(capsys, compiled):
    """Run the command line; returns exit status, standard output and standard error."""

    def run(*arguments):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as end:  # argparse
            status = end.code
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


@pytest.fixture
def solved(cpr):
    """Run the command line with --json; returns the equilibrium."""

    def run(*arguments):
        status, out, err = cpr(*arguments, "--json")
        assert (status, err) == (0, "")
        return json.loads(out)

    return run


@pytest.fixture
def failed(cpr):
    """Run the command line, which fails; returns status and code and message of the error."""

    def run(*arguments):
        status, out, err = cpr(*arguments, "--json")
        assert err == ""
        error = json.loads(out)
        assert set(error) == {"error"}
        assert set(error["error"]) == {"code", "message"}
        # The same without JSON, where it goes to standard error.
        assert cpr(*arguments) == (status, "", f"cpr: error: {error['error']['message']}\n")
        return status, error["error"]["code"], error["error"]["message"]

    return run


@pytest.fixture
def misused(cpr):
    """Run the command line with arguments it cannot read; returns the message."""

    def run(*arguments):
        status, out, err = cpr(*arguments)
        assert (status, out) == (2, "")
        assert err.startswith("usage: cpr")
        return err

    return run
