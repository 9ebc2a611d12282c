# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Demonstration: a node with the 6-RFS robot, driven along the paper's path by another process."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rclpy
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode
from cpr_msgs.srv import SolveForward
from rclpy.node import Node
from sensor_msgs.msg import JointState
from tqdm import tqdm

from cpr_core import CprError, load_robot

from .messages.equilibrium_messages import equilibrium_from_message
from .messages.geometry import vector_of
from .process.interrupted import interrupted
from .process.own_domain import enter_own_domain

__all__ = ["run"]

ROBOT = "six_rfs"
#: Ends of the motor path of the paper's second case study, Eq. (53) with n_c = 50.
FIRST = np.array([5.86, 5.56, 5.86, 5.46, 5.86, 5.26])
LAST = np.array([7.95, 7.65, 4.29, 3.89, 3.77, 3.17])
STEPS = 50
START_TIMEOUT = 300.0
CALL_TIMEOUT = 10.0


@dataclass(frozen=True)
class Step:
    """One answer of the node.

    Attributes:
        t: Number of the configuration on the path.
        solution: What the node answered.
        round_trip: Time from request to answer [s].
    """

    t: int
    solution: EquilibriumMessage
    round_trip: float


def run(arguments: list[str]) -> int:
    """Run the demonstration; the first argument is the program. Returns the exit status."""
    parser = argparse.ArgumentParser(prog="cpr_demo", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("demo"), help="folder of the picture")
    options = parser.parse_args(arguments[1:])
    domain = enter_own_domain()  # what is shown here is sent to no robot
    print(f"ROS_DOMAIN_ID={domain.number}, on this machine only: starting cpr_node with {ROBOT}")
    with tempfile.TemporaryFile("w+") as log, tempfile.TemporaryDirectory() as folder:
        # It begins at home, whatever was done before.
        parameters = ["-p", f"robot:={ROBOT}", "-p", f"state_directory:={folder}"]
        node = subprocess.Popen(
            [sys.executable, "-m", "cpr_ros.cpr_node", "--ros-args", *parameters],
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        try:
            steps = _drive(node)
        except CprError as error:
            log.seek(0)
            print(f"cpr_demo: {error}\n--- log of the node ---\n{log.read()}", file=sys.stderr)
            return 1
        finally:
            status = interrupted(node)
    print(_table(steps))
    picture = _draw(steps, options.output)
    print(f"picture: {picture}")
    program = Path(sys.executable).with_name("cpr")
    print(f"look at the robot and move it, in the browser: {program} view {ROBOT}")
    return 0 if status == 0 else 1


def _drive(process: subprocess.Popen[bytes]) -> list[Step]:
    """Send the path to the node, one configuration after the other."""
    rclpy.init()
    client_node = Node("cpr_demo")
    client = client_node.create_client(SolveForward, "/cpr_node/solve_forward")
    try:
        begin = time.monotonic()
        with tqdm(
            total=None,
            desc="waiting for the node",
            bar_format="{desc} {elapsed}",
            disable=None,
            leave=False,
        ) as waiting:
            while not client.wait_for_service(timeout_sec=0.5):
                waiting.refresh()
                if process.poll() is not None:
                    raise CprError(f"the node ended with status {process.returncode}")
                if time.monotonic() - begin > START_TIMEOUT:
                    raise CprError("the node did not offer its service in time")
        steps = []
        for t in tqdm(range(STEPS + 1), desc="path of Eq. (53)", unit="pose", disable=None):
            request = SolveForward.Request(
                motors=JointState(
                    name=[f"motor{number + 1}" for number in range(len(FIRST))],
                    position=(FIRST + (LAST - FIRST) * t / STEPS).tolist(),
                ),
                apply=True,
                with_eigenvalues=True,
            )
            sent = time.perf_counter()
            answer = _call(client_node, client, request)
            if answer.error_code.val != ErrorCode.SUCCESS:
                raise CprError(f"t = {t}: {answer.error_code.message}")
            steps.append(Step(t, answer.solution, time.perf_counter() - sent))
        return steps
    finally:
        client_node.destroy_node()
        rclpy.try_shutdown()


def _call(node: Node, client: rclpy.client.Client, request: SolveForward.Request):  # type: ignore[no-untyped-def]
    """Call a service, not waiting for ever."""
    future = client.call_async(request)
    end = time.monotonic() + CALL_TIMEOUT
    while not future.done():
        if time.monotonic() > end:
            raise CprError("the node did not answer in time")
        rclpy.spin_once(node, timeout_sec=0.1)
    return future.result()


def _table(steps: list[Step]) -> str:
    """Every fifth configuration, and the medians of the times."""
    lines = [
        "",
        "  t        x        y        z   [m]      qw       qx       qy       qz"
        "   smallest eigenvalue [J]   solve [ms]",
    ]
    for step in steps[:: max(1, STEPS // 10)]:
        pose = step.solution.platform_in_base
        point, turn = pose.position, pose.orientation
        lines.append(
            f"{step.t:3d} {point.x:8.4f} {point.y:8.4f} {point.z:8.4f}       "
            f"{turn.w:8.4f} {turn.x:8.4f} {turn.y:8.4f} {turn.z:8.4f}"
            f"   {step.solution.smallest_eigenvalue_locked:23.5f}"
            f"   {1e3 * step.solution.solve_time:10.2f}"
        )
    solve = 1e3 * float(np.median([step.solution.solve_time for step in steps]))
    trip = 1e3 * float(np.median([step.round_trip for step in steps]))
    lines.append(f"medians of {len(steps)}: solve {solve:.2f} ms, request to answer {trip:.2f} ms")
    return "\n".join(lines)


def _draw(steps: list[Step], folder: Path) -> Path:
    """The robot along the path, as in Fig. 10."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    from cpr_core.drawing.robot_drawing import draw_equilibrium, set_equal_scale

    robot = load_robot(ROBOT)
    figure = plt.figure(figsize=(7.5, 7.0))
    axes = figure.add_subplot(projection="3d")
    shown = steps[:: STEPS // 5]
    colors = mpl.colormaps["viridis"](np.linspace(0.0, 0.9, len(shown)))
    for step, color in zip(shown, colors, strict=True):
        draw_equilibrium(
            axes, equilibrium_from_message(robot, step.solution), color=color, label=f"t = {step.t}"
        )
    path = np.array([vector_of(step.solution.platform_in_base.position) for step in steps])
    axes.plot(*path.T, color="black", linewidth=1.0, linestyle=":", label="platform")
    axes.set_title("6-RFS robot along the motor path of Eq. (53)")
    axes.legend(loc="upper left", fontsize=8)
    set_equal_scale(axes)
    folder.mkdir(parents=True, exist_ok=True)
    picture = folder / "six_rfs_path.png"
    figure.savefig(picture, dpi=150, bbox_inches="tight")
    plt.close(figure)
    return picture
