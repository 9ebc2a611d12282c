# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Importing the package where the shell has little."""

import os
import subprocess
import sys

_BARE = "import pwd; pwd.getpwuid = {}.__getitem__; import cpr_ros; print('imported')"


def test_a_user_without_a_home_may_import_the_package():
    """A container with the number of a user that nobody has listed: there was a traceback."""
    environment = {name: value for name, value in os.environ.items() if name != "HOME"}
    done = subprocess.run(
        [sys.executable, "-c", _BARE], env=environment, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("imported\n", "")
