# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Nothing that a test starts is heard outside: a domain of its own, on this machine only."""

from cpr_ros.own_domain import enter_own_domain

_OWN_DOMAIN = enter_own_domain()
