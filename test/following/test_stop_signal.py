# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Signals that come where Python cannot raise them, in a process of its own."""

import subprocess
import sys
import textwrap

import pytest


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_an_interrupt_within_a_finaliser_comes_again_and_says_nothing(name):
    script = f"""
        import signal, time
        from cpr_ros.stop_signal import StopSignal

        stop = StopSignal()

        class Fragile:
            def __del__(self):
                signal.raise_signal(signal.{name})

        try:
            Fragile()
            time.sleep(30.0)
        except KeyboardInterrupt:
            print("interrupted", stop.requested)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=25
    )
    assert done.returncode == 0
    assert done.stdout == "interrupted True\n"
    assert done.stderr == ""


def test_signals_while_spinning_are_only_remembered():
    script = """
        import signal
        from cpr_ros.stop_signal import StopSignal

        stop = StopSignal()
        stop.interrupts = False
        signal.raise_signal(signal.SIGTERM)
        print("remembered", stop.requested)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=25
    )
    assert (done.returncode, done.stdout) == (0, "remembered True\n")


def test_other_errors_in_finalisers_are_still_told():
    script = """
        from cpr_ros.stop_signal import StopSignal

        StopSignal()

        class Broken:
            def __del__(self):
                raise ValueError("broken finaliser")

        Broken()
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=25
    )
    assert "broken finaliser" in done.stderr
