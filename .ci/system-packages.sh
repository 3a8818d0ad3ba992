#!/bin/sh
# Install the missing Debian packages for a purpose; without permission, print the command.
# Usage: system-packages.sh venv|run|firmware|test|fuzz|bench [PYTHON]
set -eu

# libraries of Qt's xcb, offscreen and OpenGL plug-ins, and one font
RUN="libegl1 libgl1 libglib2.0-0 libfontconfig1 libdbus-1-3 libx11-xcb1 libxkbcommon0 libxkbcommon-x11-0
    libxcb-cursor0 libxcb-icccm4 libxcb-image0 libxcb-keysyms1 libxcb-randr0 libxcb-render-util0 libxcb-shape0
    libxcb-shm0 libxcb-sync1 libxcb-xfixes0 libxcb-xkb1 fonts-dejavu-core"
FIRMWARE="gcc-avr avr-libc arduino-core-avr"
# libFuzzer and its sanitizers; other releases use a fuzzer built with g++
FUZZ=
grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release && FUZZ="clang-14 libclang-rt-14-dev"
TEST="$RUN $FIRMWARE $FUZZ avrdude gcc g++ libc6-dev simavr libsimavr-dev libelf-dev xvfb xdotool"

case "$1" in
venv) wanted=python3-venv; "${2:-python3}" -c "import ensurepip" 2>/dev/null && wanted= ;;
run) wanted=$RUN ;;
firmware) wanted="$FIRMWARE gcc libc6-dev libsimavr-dev libelf-dev" ;;
test) wanted=$TEST ;;
fuzz) wanted="gcc g++ libc6-dev $FUZZ" ;;
bench) wanted="$TEST rt-tests" ;;
*) echo "unknown purpose: $1" >&2; exit 2 ;;
esac

command -v apt-get >/dev/null && command -v dpkg-query >/dev/null || exit 0

installed() {
    dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null | grep -q '^installed'
}

missing=
for package in $wanted; do
    # newer releases renamed some libraries
    installed "$package" || installed "${package}t64" || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

line="apt-get update && apt-get install -y --no-install-recommends$missing"
if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
    as_root=sudo
else
    as_root=none
fi
if [ "$as_root" != none ]; then
    echo "Installing:$missing"
    # shellcheck disable=SC2086
    $as_root apt-get update -qq || true
    $as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get -o DPkg::Lock::Timeout=600 install -y -qq --no-install-recommends $missing </dev/null >/dev/null && exit 0
fi
echo "System packages are missing. Run this once as root, then again what you ran:"
echo "    $line"
# the window may do without some of them, checks that were skipped would only seem to have passed
[ "$1" = run ]
