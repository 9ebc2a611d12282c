# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Version of the package."""

__all__ = ["__version__"]

__version__ = "0.1.0"
