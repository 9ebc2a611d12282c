# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Numbers in print: ours agree to the digits there are."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from verification.published import FAMILIES, POSTBUCKLING, Published, as_printed


@pytest.fixture(scope="module")
def numbers():
    return {name: tuple(family()) for name, family in FAMILIES.items()}


@pytest.mark.parametrize("family", FAMILIES)
def test_ours_agree_with_the_numbers_in_print(numbers, family):
    assert len(numbers[family]) >= 6
    far = [number for number in numbers[family] if not number.met]
    assert far == []


def test_a_number_that_may_be_farther_than_its_last_digit_says_why(numbers):
    for number in (number for family in numbers.values() for number in family):
        digits = len(number.printed.partition(".")[2])
        assert number.why or number.reach < 0.6 * 10.0**-digits, number.name


@pytest.mark.parametrize("angle", POSTBUCKLING)
def test_the_elastica_is_that_of_elliptic_integrals(numbers, angle):
    """What the table of the book is of; its own digits are cut off."""
    load, along, across = (
        number.ours for number in numbers["elastica"] if f" {angle}°" in number.name
    )
    m = np.sin(np.radians(angle) / 2.0) ** 2
    k = ellipk(m)
    assert load == pytest.approx((2.0 * k / np.pi) ** 2, abs=1e-8)
    assert along == pytest.approx(2.0 * ellipe(m) / k - 1.0, abs=1e-8)
    assert across == pytest.approx(2.0 * np.sqrt(m) / k, abs=1e-8)


def test_a_number_beyond_its_last_digit_is_not_met():
    assert as_printed("", "", "7.8373", 7.83734).met
    assert not as_printed("", "", "7.8373", 7.83736).met
    assert not Published("", "", "1.063", 1.0645, 1e-3, "cut off").met
