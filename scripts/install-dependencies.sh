#!/usr/bin/env bash
# Installs what altiro3D needs on Debian 12 or 13, or Ubuntu.
#
#   scripts/install-dependencies.sh build    to build and run the tools, and to download depth networks
#   scripts/install-dependencies.sh test     and to run all tests and checks
#   scripts/install-dependencies.sh cluster  to run altiro3Dcluster on Slurm and by ssh, all on this machine
#   scripts/install-dependencies.sh arm64    to build for arm64 and to run it in an emulator (scripts/check-arm64.sh)
#   scripts/install-dependencies.sh web      to build and check the library for browsers (scripts/build-web.sh)
#   scripts/install-dependencies.sh package  to build the tools and make and check packages of them
#   scripts/install-dependencies.sh archive  to make and check an archive for any Linux
#   scripts/install-dependencies.sh windows  to build the tools for Windows, and to try them with Wine
#
# The output of apt goes to build/packages.log, or to the file that $ALTIRO3D_LOG names.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"

build=(g++ cmake ninja-build pkg-config libopencv-dev libturbojpeg0-dev libpng-dev libheif-dev libopenexr-dev
       liblcms2-dev libtiff-dev libhwy-dev zlib1g-dev libzstd-dev libexpat1-dev qtbase5-dev libqt5svg5
       nlohmann-json3-dev libavformat-dev libavcodec-dev libavfilter-dev libavutil-dev libswscale-dev
       libswresample-dev
       libavdevice-dev libsdl2-dev pybind11-dev python3-dev python3-numpy
       python3 curl ca-certificates)
tests=(libgtest-dev libbenchmark-dev clang clang-format clang-tidy cppcheck valgrind doxygen graphviz
       mypy python3-venv python3-setuptools python3-wheel python3-jsonschema git ffmpeg groff-base man-db zsh
       xvfb xdotool desktop-file-utils shared-mime-info libclang-rt-dev llvm locales mpv mesa-vulkan-drivers
       xauth g++-mingw-w64-x86-64-posix) # reads sources as for Windows
cluster=(slurm-wlm munge parallel openssh-server openssh-client)
arm64=(cmake ninja-build pkg-config g++-aarch64-linux-gnu qemu-user)
web=(emscripten cmake ninja-build dpkg-dev nlohmann-json3-dev brotli chromium)
packages=(lintian debootstrap dpkg-dev file git)
archive=(patchelf xz-utils)
windows=(g++-mingw-w64-x86-64-posix mingw-w64-tools libz-mingw-w64-dev nasm meson ninja-build cmake make pkg-config
         dpkg-dev protobuf-compiler qtbase5-dev-tools nlohmann-json3-dev pandoc
         librsvg2-bin nsis zip libgtest-dev wine wine64 xvfb xdotool ffmpeg)
optional=(libonnxruntime-dev) # where the distribution has them

case "${1:-build}" in
build) wanted=("${build[@]}") ;;
test) wanted=("${build[@]}" "${tests[@]}") ;;
cluster) wanted=("${build[@]}" "${tests[@]}" "${cluster[@]}") ;;
arm64) wanted=("${arm64[@]}") ;;
web)
    wanted=("${web[@]}")
    command -v npm >/dev/null || wanted+=(nodejs npm)
    ;;
package) wanted=("${build[@]}" "${packages[@]}") ;;
package-arm64) # headers and libraries of arm64 (scripts/make-packages.sh --arch arm64)
    wanted=(crossbuild-essential-arm64 libpython3-dev:arm64 "${packages[@]}")
    for package in "${build[@]}"; do
        [[ $package != lib*-dev && $package != qtbase5-dev ]] || package+=:arm64
        wanted+=("$package")
    done
    ;;
archive) wanted=("${build[@]}" "${packages[@]}" "${archive[@]}") ;;
windows) wanted=("${windows[@]}") ;;
*)
    wrong_usage "$1: unknown, expected build, test, cluster, arm64, web, package, archive or windows"
    ;;
esac
if ! command -v apt-get >/dev/null; then
    echo "$0: apt-get: is not there, expected Debian or Ubuntu; needed are ${wanted[*]}" >&2
    exit 1
fi

missing=()
add_missing() { # package...
    local package status
    for package; do
        status=$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)
        [[ $status == ii* ]] || missing+=("$package")
    done
}
add_missing "${wanted[@]}"
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
    if ! command -v sudo >/dev/null; then
        echo "$0: these packages are missing: ${missing[*]}; install them as root" >&2
        exit 1
    fi
    as_root=(sudo)
fi
# shellcheck source=scripts/log.sh
. "$(dirname "$0")/log.sh"
log_to "${ALTIRO3D_LOG:-$(dirname "$0")/../build/packages.log}"
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
logged "${apt[@]}" update
for package in "${optional[@]}"; do
    [[ -z $(apt-cache show "$package" 2>/dev/null) ]] || add_missing "$package"
done
# Each line: address, file, bytes, checksum.
files=$(apt-get install --print-uris -qq --no-install-recommends "${missing[@]}" 2>>"$log" || true)
summary=$(awk '$3 ~ /^[0-9]+$/ { count++; bytes += $3 }
    END { printf "%d packages, %.0f MB to download", count, bytes / 1e6 }' <<<"$files")
echo "Installing $summary: ${missing[*]}"
logged "${apt[@]}" install --no-install-recommends "${missing[@]}"
