# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Limits of sequences whose errors are known."""

import numpy as np
import pytest

from verification.extrapolation import limit_of_powers, richardson


@pytest.mark.parametrize(("order", "step"), [(1, 1), (2, 2), (4, 2)])
def test_parts_of_the_error_go_one_by_one(order, step):
    limit, parts = np.array([2.0, -3.0]), np.array([[0.5, 0.7], [0.3, -0.2]])

    def answer(size):
        powers = size ** np.array([order, order + step])
        return limit + powers @ parts

    found, change = richardson([answer(size) for size in (1.0, 0.5, 0.25)], order, step)
    np.testing.assert_allclose(found, limit, atol=1e-14)
    two, _ = richardson([answer(size) for size in (0.5, 0.25)], order, step)
    np.testing.assert_allclose(found - two, change, atol=1e-14)
    assert np.abs(change).max() > 1e-4


def test_one_answer_has_no_limit():
    with pytest.raises(ValueError, match="two answers or more, got 1"):
        richardson([np.zeros(3)], 2)


def test_lengths_need_not_be_halved():
    limit, parts = np.array([2.0, -3.0]), np.array([[0.5, 0.7], [0.3, -0.2]])
    sizes = (1.0, 0.4, 0.15)
    answers = [limit + size ** np.array([2, 3]) @ parts for size in sizes]
    np.testing.assert_allclose(limit_of_powers(answers, sizes, (2, 3)), limit, atol=1e-14)
    assert np.abs(limit_of_powers(answers, sizes, (2, 4)) - limit).max() > 1e-3
    with pytest.raises(ValueError, match="expected 3 answers, got 2"):
        limit_of_powers(answers[:2], sizes[:2], (2, 3))
