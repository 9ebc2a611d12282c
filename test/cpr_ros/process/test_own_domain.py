# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Domains of tests and of the demonstration are nobody else's."""

import os
import subprocess
import sys
from contextlib import contextmanager

import pytest
from helpers import node_process

from cpr_ros.process.own_domain import DOMAINS, OwnDomain, private_environment, used_domains

#: Somebody in a domain of their own choice, as a robot is.
STRANGER = """
import sys
import cpr_ros, rclpy
rclpy.init()
node = rclpy.create_node("robot")
print("there", flush=True)
sys.stdin.read()
"""


@contextmanager
def somebody_in(number):
    """A participant in a domain, until it is let go."""
    process = subprocess.Popen(
        [sys.executable, "-c", STRANGER],
        env=os.environ | {"ROS_DOMAIN_ID": str(number)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout.readline() == "there\n"
        yield
    finally:
        process.communicate()


@pytest.fixture
def stranger():
    """The domain of a participant that took no lock."""
    own = OwnDomain()
    with somebody_in(own.number):
        own.close()  # not before: another worker would take a domain in which somebody is soon
        yield own.number


def test_a_domain_with_a_participant_is_left_alone(stranger):
    assert stranger in used_domains()
    with pytest.raises(OSError, match="in use"):
        OwnDomain([stranger])
    other = OwnDomain([stranger, *DOMAINS])
    assert other.number != stranger
    other.close()


def test_a_domain_is_empty_until_somebody_is_in_it():
    own = OwnDomain()
    assert own.empty
    with somebody_in(own.number):
        assert not own.empty
    assert own.empty
    own.close()


def test_domains_of_tests_are_used_again_and_never_while_somebody_is_there(stranger, monkeypatch):
    """Six workers that took 24 each had left none."""
    occupied = OwnDomain.__new__(OwnDomain)
    occupied.number = stranger
    monkeypatch.setattr(node_process, "_own", [occupied])
    taken = [node_process.free_domain() for _ in range(3 * node_process.OWN_DOMAINS)]
    assert stranger not in taken
    assert len(set(taken)) == node_process.OWN_DOMAINS - 1
    for own in node_process._own[1:]:
        own.close()


def test_no_domain_has_ports_that_the_system_gives_to_anybody():
    """A socket of somebody else was now and then in domain 101, which then was in use."""
    first_of_anybody = 32768  # as Linux has it, if nobody has changed it
    assert 7400 + 250 * (max(DOMAINS) + 1) <= first_of_anybody
    assert min(DOMAINS) > 0  # there are all who chose none


def test_a_domain_belongs_to_one_until_it_is_let_go():
    first = OwnDomain(reversed(DOMAINS))  # other workers take the first, also one that is let go
    with pytest.raises(OSError, match="in use"):
        OwnDomain([first.number])
    assert OwnDomain().number != first.number
    first.close()
    again = OwnDomain([first.number])
    again.close()


def test_nothing_in_the_shell_leads_out_of_this_machine(stranger):
    leading_out = {
        "ROS_STATIC_PEERS": "192.168.0.9",
        "ROS_DISCOVERY_SERVER": "192.168.0.9:11811",
        "FASTDDS_ENVIRONMENT_FILE": "/etc/discovery_server.json",
    }
    shell = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "PATH": "/bin"}
    private = private_environment(shell | leading_out)
    assert private["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert private["PATH"] == "/bin"
    assert not leading_out.keys() & private.keys()
    own = OwnDomain()
    shell["ROS_DOMAIN_ID"] = str(stranger)
    assert own.environment(shell)["ROS_DOMAIN_ID"] == str(own.number) != str(stranger)
    own.close()


def test_the_demonstration_takes_no_domain_from_the_shell(stranger):
    code = "from cpr_ros.process.own_domain import enter_own_domain as enter; print(enter().number)"
    said = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"ROS_DOMAIN_ID": str(stranger)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert int(said) != stranger
