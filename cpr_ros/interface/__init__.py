# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What others reach the node by, and what it tells them: topics, services, actions."""
