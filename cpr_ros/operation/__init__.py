# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""One robot in operation: where it is, where it was, what it answers."""
