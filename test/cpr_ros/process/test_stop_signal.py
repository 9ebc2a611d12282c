# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Signals wherever Python is just then, each time in a process of its own."""

import signal
import subprocess
import sys
import textwrap
import time

import pytest

NAMES = ["SIGINT", "SIGTERM"]


def done(script):
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=25
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_signal_within_a_finaliser_ends_the_start_and_says_nothing(name):
    script = f"""
        import signal, time
        from cpr_ros.process.stop_signal import StopSignal

        stop = StopSignal()

        class Fragile:
            def __del__(self):
                signal.raise_signal(signal.{name})

        Fragile()
        time.sleep(30.0)
    """
    ended = done(script)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


@pytest.mark.parametrize("name", NAMES)
def test_a_signal_in_a_callback_of_compiled_code_raises_nothing_there(name):
    """In such a callback, as LLVM has them, an exception would be lost or worse."""
    script = f"""
        import ctypes, signal
        from cpr_ros.process.stop_signal import StopSignal

        stop = StopSignal()
        stop.remember()
        calls = []

        @ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
        def compare(first, second):
            signal.raise_signal(signal.{name})
            calls.append(first)
            return 0

        numbers = (ctypes.c_int * 8)()
        ctypes.CDLL(None).qsort(numbers, 8, 4, compare)
        print("remembered", stop.requested, len(calls) >= 7)
    """
    ended = done(script)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "remembered True True\n", "")


def test_results_and_errors_of_what_takes_long_come_back():
    script = """
        from cpr_ros.process.stop_signal import StopSignal

        stop = StopSignal()
        print(stop.wait_for(lambda: 42))
        try:
            stop.wait_for(lambda: 1 // 0)
        except ZeroDivisionError as error:
            print(error)
    """
    ended = done(script)
    assert ended.stdout.splitlines() == ["42", "integer division or modulo by zero"]


@pytest.mark.parametrize("name", NAMES)
def test_what_cannot_be_interrupted_does_not_hold_up_the_end(name):
    """A call of C that lasts half a minute, and clean-up that is told to stop once more."""
    script = f"""
        import ctypes, signal, threading, time
        from cpr_ros.process.stop_signal import Stopped, StopSignal

        stop = StopSignal()
        stop.remember()
        main = threading.main_thread().ident
        threading.Timer(0.3, signal.pthread_kill, (main, signal.{name})).start()
        try:
            stop.wait_for(lambda: ctypes.CDLL(None).sleep(30))
        except Stopped:
            signal.raise_signal(signal.{name})
            print("cleaned up")
            stop.finish(0)
    """
    begin = time.monotonic()
    ended = done(script)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "cleaned up\n", "")
    assert time.monotonic() - begin < 10.0


@pytest.mark.parametrize("name", NAMES)
def test_signals_that_come_all_the_time_do_not_disturb_the_end(name):
    script = f"""
        import signal, threading, time
        from cpr_ros.process.stop_signal import StopSignal

        stop = StopSignal()
        stop.remember()
        main = threading.main_thread().ident

        def send():
            while True:
                signal.pthread_kill(main, signal.{name})
                time.sleep(1e-4)

        threading.Thread(target=send, daemon=True).start()
        while not stop.requested:
            pass
        print("kept", end="")
        stop.finish(3)
    """
    ended = done(script)
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, "kept", "")


@pytest.mark.parametrize("name", NAMES)
def test_a_signal_that_the_parent_holds_back_is_taken_by_the_first_line(name):
    number = signal.Signals[name]
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        process = subprocess.Popen(
            [sys.executable, "-m", "cpr_ros.cpr_node"], stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    process.send_signal(number)  # Python has hardly begun
    _, said = process.communicate(timeout=25)
    assert (process.returncode, said) == (0, "")


def test_other_errors_in_finalisers_are_still_told():
    script = """
        from cpr_ros.process.stop_signal import StopSignal

        StopSignal()

        class Broken:
            def __del__(self):
                raise ValueError("broken finaliser")

        Broken()
    """
    assert "broken finaliser" in done(script).stderr
