# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A cpr_node in its own process and a client beside it, talking over real DDS."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from cpr_ros.process.own_domain import OwnDomain, private_environment
from helpers.copied_process import CopiedProcess
from helpers.imported_node import ImportedNode

#: Starting includes compiling the kernels on a fresh machine.
START_TIMEOUT = 240.0
TIMEOUT = 20.0
#: Time limit of requests: what they come to does not depend on how busy the computer is [s].
TIME_LIMIT = 5.0

#: As many domains as one process takes: six workers and the tests that take many at once have enough.
OWN_DOMAINS = 8
_own: list[OwnDomain] = []


def free_domain() -> int:
    """A ROS domain for one test, so that tests do not hear each other, nor anybody else.

    It is taken until this process ends: other workers and other runs on this machine take others. Once
    it has enough, one in which nobody is any more is used again, the longest unused.
    """
    known = next((own for own in _own if own.empty), None) if len(_own) >= OWN_DOMAINS else None
    if known is not None:
        _own.remove(known)
    _own.append(known or OwnDomain())
    return _own[-1].number


class NodeProcess:
    """A running cpr_node: begun by Python if ``cold``, else a copy; of what is ``imported`` if given."""

    def __init__(
        self,
        log: Path,
        domain: int,
        arguments: Sequence[str],
        module: str = "cpr_ros.cpr_node",
        *,
        cold: bool = False,
        imported: ImportedNode | None = None,
    ) -> None:
        self.log = log
        self._home = tempfile.TemporaryDirectory()  # nothing is known of where the robot was
        self.home = Path(self._home.name)
        environment = private_environment() | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_HOME": self._home.name,
        }
        arguments = ["--ros-args", *arguments]
        log.touch()
        self.process: subprocess.Popen[bytes] | CopiedProcess | ImportedNode
        if imported is not None:
            imported.start(arguments, environment, log)
            self.process = imported
            return
        if not cold:
            self.process = CopiedProcess(module, arguments, environment, log)
            return
        with log.open("w") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", module, *arguments],
                stdout=output,
                stderr=subprocess.STDOUT,
                env=environment,
            )

    def wait_for_log(self, text: str, timeout: float = START_TIMEOUT) -> None:
        end = time.monotonic() + timeout
        while text not in self.output():
            assert self.process.poll() is None, f"the node ended:\n{self.output()}"
            assert time.monotonic() < end, f"no {text!r} in the log:\n{self.output()}"
            time.sleep(0.05)

    def output(self) -> str:
        return self.log.read_text()

    def stop(self, how: signal.Signals = signal.SIGINT) -> int:
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            return self.process.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"the node did not stop on {how.name}:\n{self.output()}") from None


class _QuietNode(Node):
    """Says nothing of events of its topics unless asked to: two each, that every wait goes through."""

    def create_publisher(self, *arguments: Any, **options: Any) -> Publisher:
        options.setdefault("event_callbacks", PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(*arguments, **options)

    def create_subscription(self, *arguments: Any, **options: Any) -> Subscription:
        unheard = SubscriptionEventCallbacks(use_default_callbacks=False)
        options.setdefault("event_callbacks", unheard)
        return super().create_subscription(*arguments, **options)


class Client:
    """A controller's side: calls services, listens to topics."""

    def __init__(self, domain: int) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        # Without services of its own, which nobody asks and every wait for a message goes through.
        self.node = _QuietNode(
            f"client_{domain}",
            context=self.context,
            start_parameter_services=False,
            enable_rosout=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._clients: dict[str, Any] = {}

    def spin_until(self, done: Callable[[], bool], timeout: float = TIMEOUT) -> None:
        end = time.monotonic() + timeout
        while not done():
            assert time.monotonic() < end, "timed out"
            self.executor.spin_once(timeout_sec=0.05)

    def call(self, kind: type, name: str, request: Any, timeout: float = TIMEOUT) -> Any:
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self.node.create_client(kind, name)
            assert client.wait_for_service(TIMEOUT), f"no service {name}"
        future = client.call_async(request)
        self.spin_until(future.done, timeout)
        return future.result()

    def messages(self, kind: type, topic: str, count: int) -> list[Any]:
        """The next messages of a topic."""
        received: list[Any] = []
        subscription = self.node.create_subscription(kind, topic, received.append, 100)
        self.spin_until(lambda: len(received) >= count)
        self.node.destroy_subscription(subscription)
        return received

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def change(client: Client, transition: int) -> bool:
    """Take the node through a transition of its life; whether it went."""
    request = ChangeState.Request(transition=Transition(id=transition))
    # To be configured it may have to compile.
    return client.call(ChangeState, "/cpr_node/change_state", request, START_TIMEOUT).success


@dataclass(frozen=True)
class Running:
    """A node and a client."""

    process: NodeProcess
    client: Client


@contextmanager
def running_node(
    folder: Path, *values: str, module: str = "cpr_ros.cpr_node", cold: bool = False
) -> Iterator[Running]:
    """A node that is ready, alone in a domain with a client; in the end it has to stop with status 0.

    Args:
        folder: Where its log is.
        values: Parameters, ``name:=value`` each.
        module: The program.
        cold: Whether Python starts with it.
    """
    domain = free_domain()
    arguments = [word for value in values for word in ("-p", value)]
    process = NodeProcess(folder / "node.log", domain, arguments, module, cold=cold)
    try:
        process.wait_for_log("ready")
        client = Client(domain)
        try:
            yield Running(process, client)
        finally:
            client.close()
    finally:
        assert process.stop() == 0, process.output()
