# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Between messages and values, both ways."""
