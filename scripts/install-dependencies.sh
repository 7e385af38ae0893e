#!/usr/bin/env bash
# Installs what altiro3D needs on Debian 12 or 13, or Ubuntu.
#
#   scripts/install-dependencies.sh build    to build and run the tools
#   scripts/install-dependencies.sh test     and to run all tests and checks
#   scripts/install-dependencies.sh package  to build the tools and make and check packages of them
set -euo pipefail

build=(g++ cmake ninja-build pkg-config libopencv-dev libexif-dev libhwy-dev zlib1g-dev qtbase5-dev
       libqt5svg5
       nlohmann-json3-dev libavformat-dev libavcodec-dev libavutil-dev libswscale-dev libavdevice-dev)
tests=(libgtest-dev libbenchmark-dev clang clang-format clang-tidy cppcheck valgrind doxygen graphviz python3
       python3-numpy git curl ca-certificates ffmpeg groff-base man-db zsh xvfb xdotool
       desktop-file-utils shared-mime-info libclang-rt-dev llvm locales)
packages=(lintian debootstrap dpkg-dev file git ca-certificates)

case "${1:-build}" in
build) wanted=("${build[@]}") ;;
test) wanted=("${build[@]}" "${tests[@]}") ;;
package) wanted=("${build[@]}" "${packages[@]}") ;;
*)
    echo "usage: $0 [build|test|package]" >&2
    exit 2
    ;;
esac

missing=()
for package in "${wanted[@]}"; do
    status=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)
    [[ $status == ii* ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
        echo "$0: these packages are missing: ${missing[*]}; install them as root" >&2
        exit 1
    fi
    as_root=(sudo)
fi
echo "Installing ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends "${missing[@]}"
