# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The command `cpr`: what it takes, computes and prints."""

from .command import main

__all__ = ["main"]
