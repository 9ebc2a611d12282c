# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Strain modes of a description: how many, of which strains and by which basis."""

import math
import re

import numpy as np
import pytest
from helpers.spoilt_descriptions import ROBOTS, TEXTS, full_content, put, refused

from cpr_core.description.description_file import read_description
from cpr_core.errors import CprError, InvalidRequest
from cpr_core.model.robot import Robot
from cpr_core.solving.load_robot import load_robot


@pytest.mark.parametrize("name", ROBOTS)
def test_the_number_of_modes_is_replaced_where_there_are_any(name):
    description = read_description(name).with_modes(8)
    for leg, before in zip(description.legs, read_description(name).legs, strict=True):
        assert leg.modes.counts == tuple(8 if count else 0 for count in before.modes.counts)


@pytest.mark.parametrize("modes", [0, -3])
def test_no_modes_are_refused(modes):
    with pytest.raises(CprError, match=f"modes: expected at least 1, got {modes}"):
        load_robot("rfrfr", modes=modes)


@pytest.mark.parametrize("modes", [True, 4.0, math.nan, "4", [4]])
def test_a_number_of_modes_is_a_whole_number(modes):
    told = re.escape(f"modes: expected a whole number, got {modes!r}")
    with pytest.raises(InvalidRequest, match=told):
        load_robot("rfrfr", modes=modes)


def test_a_number_of_modes_may_come_from_an_array():
    assert (
        load_robot("rfrfr", modes=np.int64(4)).state_size == load_robot("rfrfr", modes=4).state_size
    )


@pytest.mark.parametrize("modes", ["5.0", "5e0"])
def test_a_whole_number_written_as_a_float_counts_modes(file, modes):
    path = file(TEXTS["rfrfr"].replace("bending_3: 5}", f"bending_3: {modes}}}"))
    assert Robot(read_description(path)).kernel_arrays.elastic.shape == (1, 5, 5)


@pytest.mark.parametrize(
    ("value", "hint"), [(-1, "at least 0"), (41, "at most 40"), (2.5, "integer"), ("5", "integer")]
)
def test_mode_counts_are_small_whole_numbers(rfrfr, value, hint):
    put(rfrfr, ("strain", "bending_3"), value)
    refused(rfrfr, "strain.bending_3", hint, str(value))


@pytest.mark.parametrize("name", ROBOTS)
def test_at_least_one_mode_is_needed(name):
    content = full_content(name)
    content["strain"] = {"torsion": 0, "bending_2": 0, "bending_3": 0}
    refused(content, "strain", "expected at least one mode")


@pytest.mark.parametrize("which", ["torsion", "bending_2"])
def test_planar_robots_bend_in_the_plane(rfrfr, which):
    rfrfr["strain"][which] = 1
    refused(rfrfr, "strain", "bends about d3 only", "bending_3")
