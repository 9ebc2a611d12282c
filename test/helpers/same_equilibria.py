# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Equilibria of robots that are described in two ways."""

import numpy as np


def assert_same(found, expected, atol=1e-12):
    """Platform, efforts and what energy says of stability."""
    np.testing.assert_allclose(found.platform_position, expected.platform_position, atol=atol)
    np.testing.assert_allclose(found.platform_rotation, expected.platform_rotation, atol=atol)
    np.testing.assert_allclose(found.efforts, expected.efforts, atol=atol)
    assert found.index_locked == expected.index_locked
    assert found.index_free == expected.index_free
