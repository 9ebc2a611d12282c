#!/usr/bin/env bash
# Builds and tests both packages with colcon, as a user of an ordinary ROS 2 does, on the ROS 2 wheels in .venv-colcon.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/steps.sh
steps=2
venv=$PWD/.venv-colcon
exec 9<tools/colcon.sh && flock 9 # a second make waits for the first

make_environment() {
    rm -rf "$venv"
    "$PYTHON" -m venv "$venv"
}

install_wheels() {
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps --no-compile -r constraints.txt
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps --no-compile -r tools/colcon.txt
}

"$venv/bin/python" -c '' 2>/dev/null || rm -f "$venv/stamp-environment"
wheels="$venv $(checksum constraints.txt tools/colcon.txt)"
step "Python environment in .venv-colcon" "$venv/stamp-environment" "$venv" make_environment
step "ROS 2, numerical and test packages, colcon (wheels, 240 MB)" "$venv/stamp-wheels" "$wheels" install_wheels

# What sourcing /opt/ros/jazzy/setup.bash does elsewhere.
export VIRTUAL_ENV=$venv PATH=$venv/bin:$PATH AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv
# colcon stops at the first package it meets: the nested one has to be named.
colcon build --base-paths . msg_defs --event-handlers console_cohesion+ --cmake-args -DBUILD_TESTING=OFF
# Its arguments are those of pytest; colcon takes away the space in front of a dash.
colcon test --base-paths . msg_defs --event-handlers console_direct+ --pytest-args "${@/#/ }"
colcon test-result --verbose
