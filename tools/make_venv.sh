#!/bin/sh
# Makes the virtual environment $1 and installs the lock file $2 into it. $3 is the folder it all is in: the environment
# remembers it, because it has to be made anew when the folder has moved.
#
# Works with the Python that is there: $PYTHON if set, else the first of python3, python3.13 ... python3.10 that is new
# enough. Distributions may leave out ensurepip; then the system's own pip puts a pip into the environment.
set -eu

venv=$1
lock=$2
here=$3

fail() {
    echo "make setup: $1" >&2
    exit 1
}

new_enough() {
    "$1" -c 'import sys, venv; sys.exit(sys.version_info < (3, 10))' >/dev/null 2>&1
}

if [ -n "${PYTHON:-}" ]; then
    new_enough "$PYTHON" || fail "PYTHON=$PYTHON is not a Python 3.10 or later with the venv module."
    python=$PYTHON
else
    python=
    for candidate in python3 python3.13 python3.12 python3.11 python3.10 python; do
        if new_enough "$candidate"; then
            python=$candidate
            break
        fi
    done
    [ -n "$python" ] || fail "no Python 3.10 or later with the venv module found. Install one, or name it: make PYTHON=/path/to/python3.12 ..."
fi

venv_python() {
    if [ -x "$venv/Scripts/python.exe" ]; then echo "$venv/Scripts/python.exe"; else echo "$venv/bin/python"; fi
}

# Not so when it has moved, when its interpreter is gone, or when PYTHON names another version.
usable() {
    [ "$(cat "$venv/.made-in" 2>/dev/null)" = "$here" ] || return 1
    "$(venv_python)" -m pip --version >/dev/null 2>&1 || return 1
    [ -z "${PYTHON:-}" ] || [ "$("$PYTHON" -c 'import sys; print(sys.version_info[:2])')" = \
        "$("$(venv_python)" -c 'import sys; print(sys.version_info[:2])')" ]
}

if ! usable; then
    rm -rf "$venv"
    echo "make setup: virtual environment in $venv from $("$python" -c 'import sys; print(sys.executable, sys.version.split()[0])')"
    if "$python" -c 'import ensurepip' >/dev/null 2>&1; then
        "$python" -m venv "$venv"
    elif "$python" -m pip --version >/dev/null 2>&1; then
        "$python" -m venv --without-pip "$venv"
        "$python" -m pip --quiet --disable-pip-version-check --python "$(venv_python)" install pip ||
            fail "this Python has no ensurepip, and its pip could not install pip into $venv (pip 22.3 or later can)."
    else
        fail "$python has neither ensurepip nor pip. Install them (Debian, Ubuntu: apt install python3-venv), or name another Python: make PYTHON=..."
    fi
    printf '%s\n' "$here" >"$venv/.made-in"
fi

echo "make setup: installing $lock"
"$(venv_python)" -m pip --quiet --disable-pip-version-check install --require-hashes --requirement "$lock"
