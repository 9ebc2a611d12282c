#!/usr/bin/env bash
# Makes .venv: ROS 2 from PyPI, the interface package cpr_msgs, cpr_ros (editable) and all machine code that programs and
# tests would otherwise wait for. What has been made is not made again: each step leaves a stamp with a checksum of what it
# was made from, written when the step is complete. `setup.sh oldest` makes .venv-oldest in the same way, with the versions
# of tools/oldest.txt; `setup.sh verify` makes .venv and adds the programs of tools/verify.txt.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tools/steps.sh
steps=6
kind=${1:-newest}
case "$kind" in
    newest) venv=$PWD/.venv versions=(constraints.txt) ;;
    oldest) venv=$PWD/.venv-oldest versions=(constraints.txt tools/oldest.txt) ;;
    verify) venv=$PWD/.venv versions=(constraints.txt) steps=7 ;;
    *) echo "setup: expected nothing, oldest or verify, got $kind" >&2; exit 1 ;;
esac
exec 9<tools/setup.sh && flock 9 # a second make waits for the first

make_environment() {
    rm -rf "$venv"
    "$PYTHON" -m venv "$venv"
}

# The list is complete: nothing to resolve. The last version named of a package counts.
install_wheels() {
    cat "${versions[@]}" | sed 's/#.*//; s/[[:space:]]*$//; /^$/d' |
        awk -F== '{version[$1] = $2} END {for (name in version) print name "==" version[name]}' |
        sort >"$venv/versions.txt"
    # Compiled here: where Python may not write bytecode itself, every import would take three times as long.
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps -r "$venv/versions.txt"
}

# Without build isolation: what the build needs is in .venv already, which saves installing it a second time.
build_messages() {
    "$venv/bin/python" -m pip install --no-deps --no-build-isolation --force-reinstall ./msg_defs
}

# Others' programs, beside what is there: nothing else depends on them.
install_programs() {
    "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps -r tools/verify.txt
}

install_package() {
    "$venv/bin/python" -m pip install --no-deps --no-build-isolation --editable .
    # Where ROS looks for executables, and for the files that an editable install leaves out.
    local index=$venv/share/ament_index/resource_index/packages
    mkdir -p "$venv/lib/cpr_ros" "$venv/share/cpr_ros" "$index"
    ln -sf ../../bin/{cpr,cpr_node,cpr_demo,cpr_view} "$venv/lib/cpr_ros/"
    ln -sf "$PWD/resource/cpr_ros" "$index/"
    local item
    for item in package.xml config launch rviz; do
        [[ ! -e $item ]] || ln -sfn "$PWD/$item" "$venv/share/cpr_ros/$item"
    done
}

# On two cores, with what only tests use.
compile_kernels() {
    PYTHONPATH=$PWD/test "$venv/bin/python" -m helpers.compiled_kernels
}

# Not among the wheels; whoever has it installed offers FollowJointTrajectory.
build_test_messages() {
    AMENT_PREFIX_PATH=$venv PYTHONPATH=$PWD/test "$venv/bin/python" -m helpers.control_messages
}

# An environment cannot be moved, and does not survive the removal of its Python.
"$venv/bin/python" -c '' 2>/dev/null || rm -f "$venv/stamp-environment"
environment=$venv
wheels="$environment $(checksum "${versions[@]}")"
messages="$wheels $(checksum msg_defs)"
package="$wheels $(checksum setup.py setup.cfg pyproject.toml tools/setup.sh)"
kernels="$wheels $(checksum cpr_core test/helpers)"
test_messages="$wheels $(checksum msg_defs test/data/control_msgs test/helpers/control_messages.py)"

step "Python environment in ${venv##*/}" "$venv/stamp-environment" "$environment" make_environment
step "ROS 2, numerical and test packages (wheels, 310 MB)" "$venv/stamp-wheels" "$wheels" install_wheels
step "interface package cpr_msgs (generated and compiled, about a minute)" "$venv/stamp-messages" "$messages" build_messages
step "cpr_ros, editable" "$venv/stamp-package" "$package" install_package
step "kernels (compiled to machine code, about a minute)" "$venv/stamp-kernels" "$kernels" compile_kernels
step "control_msgs, with which tests talk to the node" "$venv/stamp-test-messages" "$test_messages" build_test_messages
if [[ $kind == verify ]]; then
    programs="$environment $(checksum tools/verify.txt)"
    step "programs to compare with (wheels, 30 MB)" "$venv/stamp-programs" "$programs" install_programs
fi
