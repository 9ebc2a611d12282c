# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""control_msgs: what is installed, or three of its interfaces, generated and compiled.

It is not among the wheels. What is compiled is the interface package of cpr_ros with other files in it:
by the set-up, as a program, or by the first test that needs it.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from helpers.own_tree import ROOT, TESTS

_OURS = ROOT / "msg_defs"
_BUILT_BY = ("CMakeLists.txt", "package.xml")
_INTERFACES = TESTS / "data" / "control_msgs"
#: Where the set-up keeps it.
OF_THE_SETUP = Path(sys.prefix) / "control_msgs"


def control_messages(folder: Path) -> dict[str, Path]:
    """Where to look for control_msgs first, by the environment variable that says so.

    Args:
        folder: Where it is kept once it is compiled, which takes half a minute.
    """
    if importlib.util.find_spec("control_msgs"):
        return {}
    prefix, stamp, checksum = folder / "prefix", folder / "stamp", _checksum()
    if not stamp.exists() or stamp.read_text() != checksum:
        stamp.unlink(missing_ok=True)
        _compile(folder / "package", folder / "build", prefix)
        stamp.write_text(checksum)
    (packages,) = prefix.glob("lib/*/site-packages")
    libraries = prefix / "lib"
    return {"AMENT_PREFIX_PATH": prefix, "LD_LIBRARY_PATH": libraries, "PYTHONPATH": packages}


def _checksum() -> str:
    """Of all that it is made from."""
    files = [*(_OURS / name for name in _BUILT_BY), *sorted(_INTERFACES.rglob("*.*"))]
    text = b"".join(file.read_bytes() for file in files)
    return hashlib.sha256(text + sys.prefix.encode()).hexdigest()


def _compile(package: Path, build: Path, prefix: Path) -> None:
    for folder in (package, build, prefix):
        shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(_INTERFACES, package)
    for name in _BUILT_BY:
        text = (_OURS / name).read_text(encoding="utf-8")
        assert "cpr_msgs" in text
        (package / name).write_text(text.replace("cpr_msgs", "control_msgs"), encoding="utf-8")
    # The tools of this environment, which need not be the one of the shell.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    configuring = ["cmake", "-G", "Ninja", "-S", package, "-B", build]
    configuring += [f"-DCMAKE_INSTALL_PREFIX={prefix}", f"-DPython3_EXECUTABLE={sys.executable}"]
    # Libraries find each other, also in a process that has begun without them.
    configuring += [f"-DCMAKE_INSTALL_RPATH={prefix}/lib", "-DSKBUILD=ON", "-DBUILD_TESTING=OFF"]
    for command in (configuring, ["cmake", "--build", build, "--target", "install"]):
        done = subprocess.run(
            command, env=os.environ | {"PATH": path}, capture_output=True, text=True
        )
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"


if __name__ == "__main__":
    control_messages(OF_THE_SETUP)
