#!/usr/bin/env bash
# Can this machine take the ROS 2 wheels and build the interface package? Says what is missing in one line.
set -euo pipefail
PYTHON=${PYTHON:-python3}
missing() { echo "setup: $*" >&2; exit 1; }

[[ "$(uname -sm)" == "Linux x86_64" ]] ||
    missing "the ROS 2 wheels are for x86_64 Linux, this is $(uname -sm): use an ordinary ROS 2 with colcon (see README)"
command -v "$PYTHON" >/dev/null ||
    missing "no '$PYTHON' here: apt install python3 python3-venv python3-dev, or name another with PYTHON=..."
version=$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])') ||
    missing "'$PYTHON' does not run: name another with PYTHON=..."
case "$version" in
    3.11 | 3.12 | 3.13 | 3.14) ;;
    *) missing "'$PYTHON' is Python $version, the wheels need 3.11 to 3.14: name another, for example PYTHON=python3.12" ;;
esac
"$PYTHON" -c 'import platform, sys; name, v = platform.libc_ver(); \
    sys.exit(name != "glibc" or tuple(map(int, v.split("."))) < (2, 28))' ||
    missing "the ROS 2 wheels need glibc 2.28 or newer: use an ordinary ROS 2 with colcon (see README)"
# Everything else that is missing, in one go.
packages=()
"$PYTHON" -c 'import venv, ensurepip' 2>/dev/null || packages+=("the venv module (Debian package python$version-venv or python3-venv)")
command -v "${CXX:-c++}" >/dev/null || command -v g++ >/dev/null || packages+=("a C++ compiler (Debian package g++)")
"$PYTHON" -c 'import pathlib, sysconfig, sys; sys.exit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' ||
    packages+=("Python.h (Debian package python$version-dev or python3-dev)")
if ((${#packages[@]})); then
    list=$(printf ', %s' "${packages[@]}")
    missing "missing: ${list:2}"
fi
