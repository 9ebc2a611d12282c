#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Starts the node again and again and stops it by SIGTERM or SIGINT at random times from its start on.

Every start has to end with status 0 and to say nothing but what it logs. Not counted as a fault, but
shown: signals that came while Python itself was starting, before the first line of the node, where
Python does what it always does. A share of the starts has the signals blocked by the parent, as `env
--block-signal=INT,TERM` does; for these there is no such time.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import IO

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
from cpr_ros.process.own_domain import OwnDomain  # noqa: E402

#: Of starts one after the other: what one leaves is not found by the next.
DOMAINS = [OwnDomain() for _ in range(18)]
#: What these nodes keep is not what those of the user keep.
HOME = tempfile.TemporaryDirectory()
NODE = [sys.executable, "-m", "cpr_ros.cpr_node", "--ros-args", "-p", "robot:=rfrfr"]
SIGNALS = (signal.SIGTERM, signal.SIGINT)
#: Time a node may take to end before it is killed [s].
PATIENCE = 30.0
READY = 300.0
#: Lines of the log after which some of the signals come, however fast the machine is.
STAGES = ("motors motor1", "finding home", "at home", "inverse problem", "shapes", "ready")
#: Said by DDS where two processes, of whatever domains, open the same port at once: all domains share
#: those from 7000 on, and one of the two takes the next.
PORT_OF_ANOTHER = re.compile(r"RTPS_TRANSPORT_SHM.*fastrtps_port70\d\d: open_and_lock_file failed")


@dataclass(frozen=True)
class Stop:
    """How one start is stopped.

    Attributes:
        number: Of the start.
        seed: What everything else was drawn from.
        cold: Whether no kernel is compiled yet.
        blocked: Whether the parent has blocked the signals.
        after: Line of the log from which the delay counts; empty: from the start.
        delay: Until the first signal [s].
        sent: The signals.
        pause: Between two signals [s].
    """

    number: int
    seed: str
    cold: bool
    blocked: bool
    after: str
    delay: float
    sent: tuple[signal.Signals, ...]
    pause: float


@dataclass(frozen=True)
class End:
    """How one start ended.

    Attributes:
        stop: How it was stopped.
        taken: Whether the node's own handlers were there, or the signals blocked, at the first signal.
        stage: Last line of the log.
        status: Exit status; negative: killed by a signal.
        duration: From the first signal to the end [s].
        said: Lines that are not of its log, or tell an error.
        shared: Files of DDS in shared memory that it used, its own and those of other participants.
        left: Files that were left half written.
    """

    stop: Stop
    taken: bool
    stage: str
    status: int
    duration: float
    said: tuple[str, ...]
    shared: tuple[Path, ...]
    left: int

    @property
    def good(self) -> bool:
        """Whether it ended as it should."""
        return not self.taken or (self.status == 0 and not self.said)


def drawn(number: int, options: argparse.Namespace, ready: float) -> Stop:
    """How a start is stopped, from the seed and its number."""
    seed = f"{options.seed}-{number}"
    chance = random.Random(seed)
    cold = chance.random() < options.cold
    if chance.random() < 0.5:
        after, longest = "", (2.0 if cold else 1.2) * ready
    elif cold:
        after, longest = "finding home", options.compiling  # kernels are compiled, for a minute
    else:
        after, longest = chance.choice(STAGES), 0.5
    return Stop(
        number,
        seed,
        cold,
        blocked=chance.random() < options.blocked,
        after=after,
        delay=chance.uniform(0.0, longest),
        sent=tuple(chance.choice(SIGNALS) for _ in range(chance.choice((1, 1, 2)))),
        pause=chance.uniform(0.0, 0.3),
    )


def environment(number: int, cache: Path | None) -> dict[str, str]:
    """A domain for a start that nobody uses, and a place for what it compiles."""
    changed = DOMAINS[number % len(DOMAINS)].environment() | {"ROS_HOME": HOME.name}
    if cache is not None:
        changed["NUMBA_CACHE_DIR"] = str(cache)
    return changed


def takes_signals(process: subprocess.Popen[bytes]) -> bool:
    """Whether the process has a handler for SIGTERM, or blocks it."""
    masks = {
        line.split(":")[0]: int(line.split()[1], 16)
        for line in Path(f"/proc/{process.pid}/status").read_text().splitlines()
        if line.startswith(("SigCgt", "SigBlk"))
    }
    return bool((masks["SigCgt"] | masks["SigBlk"]) >> (signal.SIGTERM - 1) & 1)


def wait_for_log(process: subprocess.Popen[bytes], log: IO[str], line: str) -> None:
    """Wait until the node has logged something; the place in the log is the node's, too: not moved."""
    begin = time.monotonic()
    while line not in (text := os.pread(log.fileno(), 1 << 16, 0).decode()):
        if process.poll() is not None or time.monotonic() - begin > READY:
            process.kill()
            raise RuntimeError(f"the node does not come to {line!r}:\n{text}")
        time.sleep(0.01)


def shared_memory(process: subprocess.Popen[bytes]) -> tuple[Path, ...]:
    """Files of participants of DDS that the process uses; ports are shared by all."""
    try:
        lines = Path(f"/proc/{process.pid}/maps").read_text().splitlines()
    except OSError:  # it has ended
        return ()
    names = {line.split()[-1] for line in lines if "/dev/shm/fastrtps_" in line}
    return tuple(Path(name) for name in names if "fastrtps_port" not in name)


def left_behind(file: Path) -> bool:
    """Whether a file of DDS is there that nobody uses.

    Processes of other domains may use one of a node here: the ports 7000 and above, which every domain
    shares, go from a participant that has ended to the next one, and with them what others still send.
    """
    if not file.exists():  # as most: nobody has to be asked
        return False
    used = any(str(file) in maps for maps in map(_mapped, Path("/proc").glob("[0-9]*")))
    return not used and file.exists()  # who ends takes it away first


def _mapped(process: Path) -> str:
    try:
        return (process / "maps").read_text()
    except OSError:  # it has ended
        return ""


def end_of(stop: Stop) -> End:
    """Start a node and stop it."""
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+") as log:
        cache = Path(folder) if stop.cold else None
        before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS if stop.blocked else ())
        begin = time.monotonic()
        try:
            process = subprocess.Popen(
                NODE, stdout=log, stderr=log, env=environment(stop.number, cache)
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if stop.after:
            wait_for_log(process, log, stop.after)
            begin = time.monotonic()
        time.sleep(max(0.0, begin + stop.delay - time.monotonic()))
        shared = shared_memory(process)
        taken, first = takes_signals(process), time.monotonic()
        for position, number in enumerate(stop.sent):
            if position:
                time.sleep(stop.pause)
            process.send_signal(number)
        try:
            status = process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            status = process.wait()
        duration = time.monotonic() - first
        log.seek(0)
        lines = [line.rstrip() for line in log if line.strip() and not PORT_OF_ANOTHER.search(line)]
        said = tuple(line for line in lines if not line.startswith("[INFO]"))
        stage = lines[-1].rpartition("]: ")[2] if lines else "nothing logged yet"
        left = sum(".tmp." in path.name for path in Path(folder).rglob("*"))
    return End(stop, taken, stage, status, duration, said, shared, left)


def time_to_ready() -> float:
    """How long a node takes to be ready here, with everything compiled [s]."""
    for _attempt in range(2):  # the first one may have to compile
        with tempfile.TemporaryFile("w+") as log:
            begin = time.monotonic()
            process = subprocess.Popen(NODE, stdout=log, stderr=log, env=environment(0, None))
            wait_for_log(process, log, "ready")
            ready = time.monotonic() - begin
            process.terminate()
            process.wait(PATIENCE)
            log.seek(0)
            if "compiling kernels" not in log.read():
                break
    return ready


def stage_of(end: End) -> str:
    """In which stage the signal came, without what differs from run to run."""
    kind = "cold" if end.stop.cold else "warm"
    words = end.stage.split(" after ")[0].split(" (after")[0]
    return f"{kind}: {words[:60]}"


def report(ends: list[End]) -> str:
    """What came of all starts."""
    taken = [end for end in ends if end.taken]
    early = [end for end in ends if not end.taken]
    lines = [f"{len(taken)} starts with signals the node takes: exit statuses"]
    lines += [
        f"  {status:4}: {count}" for status, count in Counter(e.status for e in taken).items()
    ]
    if taken:
        times = sorted(end.duration for end in taken)
        lines.append(
            f"  from signal to end: median {times[len(times) // 2]:.2f} s, "
            f"99 % {times[int(0.99 * len(times))]:.2f} s, longest {times[-1]:.2f} s"
        )
        kinds = Counter(
            " + ".join(number.name for number in end.stop.sent)
            + (", blocked before" if end.stop.blocked else "")
            for end in taken
        )
        lines += [f"  {kind}: {count}" for kind, count in sorted(kinds.items())]
        lines.append("  last line of the log:")
        stages = Counter(map(stage_of, taken))
        lines += [f"    {stage}: {count}" for stage, count in sorted(stages.items())]
        lines.append(f"  files left half written: {sum(end.left for end in taken)}")
    lines.append(f"{len(early)} signals before the first line of the node: exit statuses")
    lines += [
        f"  {status:4}: {count}" for status, count in Counter(e.status for e in early).items()
    ]
    if early:
        lines.append(f"  the last of them {max(e.stop.delay for e in early):.3f} s after the start")
    for end in ends:
        if not end.good:
            lines.append(f"FAULT: {end}")
    return "\n".join(lines)


def main() -> int:
    """Run everything; exit status 1 if a start did not end as it should."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cold", type=float, default=0.1, help="share without compiled kernels")
    parser.add_argument(
        "--compiling", type=float, default=20.0, help="latest signal among compiling ones [s]"
    )
    parser.add_argument("--blocked", type=float, default=0.2, help="share with signals blocked")
    parser.add_argument("--together", type=int, default=2, help="starts at the same time")
    parser.add_argument("--only", type=int, help="repeat the start with this number")
    options = parser.parse_args()
    # A shell that starts this in the background lets it, and whatever it starts, ignore SIGINT.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ready = time_to_ready()
    print(f"seed {options.seed}; a node is ready after {ready:.1f} s", flush=True)
    numbers = range(options.starts) if options.only is None else [options.only]
    stops = [drawn(number, options, ready) for number in numbers]
    ends = []
    with ThreadPoolExecutor(options.together) as pool:
        for end in pool.map(end_of, stops):
            ends.append(end)
            if not end.good:
                print(f"FAULT: {end}", flush=True)
            if len(ends) % 100 == 0 and len(ends) < len(stops):
                print(f"--- {len(ends)} of {len(stops)} ---\n{report(ends)}", flush=True)
    print(report(ends))
    left = [end for end in ends if any(map(left_behind, end.shared))]
    for end in left:
        print(f"FAULT, files left in shared memory: {end}")
    print(f"starts that left files in shared memory: {len(left)}")
    good = all(end.good for end in ends) and any(end.taken for end in ends)
    return 0 if good and not left else 1


if __name__ == "__main__":
    sys.exit(main())
