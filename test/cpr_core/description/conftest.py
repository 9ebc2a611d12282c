# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions of the paper's robots, to be changed at will, and a file to write one to."""

import copy

import pytest
from helpers.spoilt_descriptions import CONTENTS


@pytest.fixture
def rfrfr():
    return copy.deepcopy(CONTENTS["rfrfr"])


@pytest.fixture
def six_rfs():
    return copy.deepcopy(CONTENTS["six_rfs"])


@pytest.fixture
def file(tmp_path):
    """Write a file and give its path."""

    def write(content):
        path = tmp_path / "robot.yaml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write
