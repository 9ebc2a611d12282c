# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers of a description: as people write them, and what is none or describes nothing."""

import math

import numpy as np
import pytest
from helpers.spoilt_descriptions import TEXTS, put, refused, written
from helpers.yaml_content import shipped_content

from cpr_core import DescriptionError, load_robot
from cpr_core.description.description_file import read_description, shipped_robots


@pytest.mark.parametrize(
    "number",
    ["210e9", "2.1e11", "2.1e+11", "21E10", "210000000000", "210_000_000_000.0", "+2.1e11"],
)
def test_numbers_are_read_as_people_write_them(file, number):
    text = TEXTS["rfrfr"].replace("210.0e+9", number)
    assert number in text
    path = file(text)
    assert read_description(path).legs[0].rod.young_modulus == 2.1e11


@pytest.mark.parametrize("number", ["1e-3", ".1e-2", "0.001", "1.e-3", "10.0E-4"])
def test_small_numbers_too(file, number):
    path = file(TEXTS["rfrfr"].replace("radius: 0.001", f"radius: {number}"))
    assert read_description(path).legs[0].rod.section.radius == 1e-3


NUMBERS = [("rod", "length"), ("rod", "section", "radius"), ("rod", "young_modulus")]
NUMBERS += [("rod", "density"), ("platform", "mass"), ("home", "motors", 1), ("gravity", 0)]
NUMBERS += [("legs", 1, "base", "position", 0), ("legs", 0, "motor", "axis", 2)]
NUMBERS += [("legs", 1, "tip", "position", 1), ("home", "platform", "position", 1)]


@pytest.mark.parametrize("value", ["long", "1 mm", True, None, [], {}, [1.0]], ids=repr)
@pytest.mark.parametrize("path", NUMBERS, ids=written)
def test_what_is_no_number_is_refused(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected number", repr(value))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("path", NUMBERS, ids=written)
def test_numbers_that_are_not_finite_are_refused(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected a finite number", str(value))


@pytest.mark.parametrize("word", [".nan", ".inf", "-.inf", "1e400"])
def test_numbers_that_are_not_finite_are_refused_in_files(file, word):
    path = file(TEXTS["rfrfr"].replace("radius: 0.001", f"radius: {word}"))
    refused(path, "rod.section.radius", "expected a finite number")


def test_arrays_that_are_no_numbers_of_yaml_are_refused(rfrfr):
    """Numbers of files for arrays come as arrays without dimensions."""
    for value in (np.array(0.5), np.array([0.5]), np.array("long")):
        rfrfr["rod"]["length"] = value
        with pytest.raises(DescriptionError, match=r"rod\.length: expected number, got array"):
            load_robot(rfrfr)


def test_nan_of_numpy_is_refused_too(rfrfr):
    put(rfrfr, ("rod", "density"), np.float32("nan"))
    with pytest.raises(DescriptionError, match=r"rod\.density"):
        read_description(rfrfr)


@pytest.mark.parametrize("value", [0, 0.0, -1, -0.001])
@pytest.mark.parametrize(
    "path", [p for p in NUMBERS if p[0] == "rod" and p[-1] != "density"], ids=written
)
def test_lengths_and_moduli_are_positive(rfrfr, path, value):
    put(rfrfr, path, value)
    refused(rfrfr, written(path), "expected a number above 0", f"got {value}")


@pytest.mark.parametrize("path", [("rod", "density"), ("platform", "mass")], ids=written)
def test_masses_are_not_negative(rfrfr, path):
    put(rfrfr, path, -1e-3)
    refused(rfrfr, written(path), "expected a number of at least 0", "got -0.001")


@pytest.mark.parametrize("word", ["210.0e+9", "length: 1.0", "7800", "-0.2"])
def test_whole_numbers_beyond_floats_are_refused(file, word):
    huge = word.rpartition(" ")[0] + " 1" + "0" * 400
    assert word in TEXTS["rfrfr"]
    path = file(TEXTS["rfrfr"].replace(word, huge, 1))
    with pytest.raises(DescriptionError, match=r"robot\.yaml"):
        read_description(path)


EXTREME = [1e-320, 1e-200, 1e-80, 1e80, 1e200, 1e308]


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("value", EXTREME)
@pytest.mark.parametrize(
    "path", [p for p in NUMBERS if p[0] == "rod" and p[-1] != "density"], ids=written
)
def test_extreme_rods_end_in_an_error_of_the_library(rfrfr, path, value):
    put(rfrfr, path, value)
    with pytest.raises(DescriptionError, match="rod"):
        load_robot(rfrfr)


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_files_are_numbers_in_every_yaml(name):
    content = shipped_content(name)
    assert isinstance(content["rod"]["young_modulus"], float)
    stiff = 210e9
    for word in ("210e9", "2.1e11", "2.1E11", "+21.e10"):
        content["rod"]["young_modulus"] = word
        assert read_description(content).legs[0].rod.young_modulus == pytest.approx(stiff)
    content["name"] = "1e5"
    assert read_description(content).name == "1e5"
    for word in ("210e9 Pa", "e9", "1e", "12", "inf"):
        content["rod"]["young_modulus"] = word
        with pytest.raises(DescriptionError, match=r"rod\.young_modulus: expected number"):
            read_description(content)


def test_numbers_are_read_as_they_look(file):
    text = shipped_robots()["rfrfr"].read_text()
    robot = load_robot(file(text.replace("density: 7800", "density: 07800")))
    assert robot.description.legs[0].rod.density == 7800.0
    with pytest.raises(DescriptionError, match=r"home\.motors\[0\]: expected number, got '1:30'"):
        load_robot(file(text.replace("[2.59, 0.55]", "[1:30, 0.55]")))
