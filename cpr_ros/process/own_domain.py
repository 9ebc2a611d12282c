# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A ROS domain that nobody uses, heard on this machine only: for demonstration, tests and measurements.

What is started there can command no robot, whatever the shell says of domains, and nobody else's
setpoints come in. No ROS here.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterable, Mapping
from pathlib import Path

__all__ = ["DOMAINS", "OwnDomain", "enter_own_domain", "private_environment", "used_domains"]

#: Those whose ports are not given to others by the operating system, which begins at 32768, among
#: those of 101; 0 is everybody's.
DOMAINS = range(1, 101)
#: Ports of a domain as DDS counts them: where those of domain 0 begin, and how many each has.
_FIRST_PORT, _PORTS = 7400, 250
#: Port among those of a domain that DDS leaves alone: whoever has it has the domain.
_LOCK = 5
#: What would let participants meet others: on other machines, by a server or profile, also from a file.
_LEADING_OUT = (
    "ROS_STATIC_PEERS",
    "ROS_LOCALHOST_ONLY",
    "ROS_DISCOVERY_SERVER",
    "ROS_SUPER_CLIENT",
    "FASTDDS_ENVIRONMENT_FILE",
    "FASTDDS_DEFAULT_PROFILES_FILE",
    "FASTRTPS_DEFAULT_PROFILES_FILE",
    "CYCLONEDDS_URI",
)


def used_domains() -> set[int]:
    """Domains of which any port is taken on this machine, as every participant takes some."""
    return {(port - _FIRST_PORT) // _PORTS for port in _used_ports() if port >= _FIRST_PORT}


def _used_ports() -> set[int]:
    """UDP ports of this machine that are taken."""
    ports = set()
    for table in ("/proc/net/udp", "/proc/net/udp6"):
        file = Path(table)
        for line in file.read_text().splitlines()[1:] if file.exists() else ():
            ports.add(int(line.split()[1].rpartition(":")[2], 16))
    return ports


class OwnDomain:
    """A domain, taken until this process ends or lets it go.

    Attributes:
        number: Of the domain.
    """

    def __init__(self, domains: Iterable[int] = DOMAINS) -> None:
        """Take the first that nobody uses.

        Args:
            domains: Those to choose from.

        Raises:
            OSError: Somebody is in every one of them.
        """
        for number in domains:
            if number in used_domains():
                continue
            lock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                lock.bind(("127.0.0.1", _FIRST_PORT + _PORTS * number + _LOCK))
            except OSError:  # somebody was faster
                lock.close()
                continue
            self.number, self._lock = number, lock
            return
        raise OSError("every ROS domain is in use on this machine")

    @property
    def empty(self) -> bool:
        """Whether nobody is in it: nothing but the lock is taken."""
        first = _FIRST_PORT + _PORTS * self.number
        return _used_ports().isdisjoint({*range(first, first + _PORTS)} - {first + _LOCK})

    def close(self) -> None:
        """Let the domain go."""
        self._lock.close()

    def environment(self, environment: Mapping[str, str] = os.environ) -> dict[str, str]:
        """The environment of processes in this domain."""
        return private_environment(environment) | {"ROS_DOMAIN_ID": str(self.number)}


def enter_own_domain() -> OwnDomain:
    """Take a domain for this process and those that it starts; before ROS is started."""
    own = OwnDomain()
    changed = own.environment()
    for name in os.environ.keys() - changed.keys():
        del os.environ[name]
    os.environ.update(changed)
    return own


def private_environment(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """An environment whose processes are heard on this machine only."""
    kept = {name: value for name, value in environment.items() if name not in _LEADING_OUT}
    return kept | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "SKIP_DEFAULT_XML_FILE": "1"}
