# Sourced by setup.sh and colcon.sh: numbered steps with a stamp each, output in a log, a sign of life on a terminal.
PYTHON=${PYTHON:-}
log=$PWD/log/setup.log
number=0
started=false
ticker=

fail() {
    stop_ticker
    printf '\nsetup failed; the end of %s:\n' "$log" >&2
    tail -n 25 "$log" >&2
    exit 1
}

# On a terminal: elapsed time and the last line of the log, once a second.
start_ticker() {
    [[ -t 1 ]] || return 0
    local columns text
    columns=$(tput cols 2>/dev/null || echo 80)
    while sleep 1; do
        text="    $SECONDS s  $(tail -n 1 "$log" | tr -cd '[:print:]')"
        printf '\r\033[K%s' "${text:0:columns-1}"
    done &
    ticker=$!
}

stop_ticker() {
    [[ -n $ticker ]] || return 0
    kill "$ticker" 2>/dev/null || true
    wait "$ticker" 2>/dev/null || true
    ticker=
    printf '\r\033[K'
}
trap stop_ticker EXIT

# The distribution's Python before others that come first in PATH: ROS 2 runs on it, and it is built with
# profile-guided optimisation, without which (pyenv's default) Python code takes a fifth to a half longer.
chosen_python() {
    local python
    for python in /usr/bin/python3 python3; do
        if PYTHON=$python bash tools/check_machine.sh 2>/dev/null; then
            echo "$python"
            return
        fi
    done
    echo python3 # what it lacks is said by who takes it
}

# Checksum of files and folders (names and contents).
checksum() {
    find "$@" -type f -not -path '*/__pycache__/*' -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -c1-16
}

# step TITLE STAMP SUM COMMAND: run COMMAND unless the file STAMP already says SUM.
step() {
    local title=$1 stamp=$2 sum=$3
    number=$((number + 1))
    [[ ! -f $stamp || $(<"$stamp") != "$sum" ]] || return 0
    if ! $started; then
        PYTHON=${PYTHON:-$(chosen_python)}
        PYTHON=$PYTHON bash tools/check_machine.sh || exit 1
        mkdir -p log
        : >"$log"
        started=true
    fi
    printf '[%d/%d] %s\n' "$number" "$steps" "$title"
    rm -f "$stamp"
    SECONDS=0
    start_ticker
    # Not `"$4" || fail`: that would switch off `set -e` inside the function.
    set +e
    (set -e; "$4") >>"$log" 2>&1
    local status=$?
    set -e
    ((status == 0)) || fail
    stop_ticker
    echo "$sum" >"$stamp"
    printf '      done in %d s\n' "$SECONDS"
}
