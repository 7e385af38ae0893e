#!/usr/bin/env bash
# Builds the library and its unit tests for arm64 (NEON), and runs the tests of up to .5 s in the emulator
# QEMU; then unpacks the packages for arm64 with all that they depend on into a bare root, and makes the Native of the
# sample photo there, which must have the bytes of this machine's. The libraries for arm64 are Debian's; they are
# unpacked into temporary directories, not installed. Needs Debian, the network (700 MB) and two hours.
#
#   scripts/check-arm64.sh [BUILD]
#
# BUILD is a build for this machine of the same commit; default: build/dev. Packages that are in
# build/package-arm64/ are taken, else scripts/make-packages.sh --arch arm64 makes them.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"
build=$(realpath "${1:-build/dev}")
cd "$(dirname "$0")/.."
# shellcheck source=scripts/bare-debian.sh
. scripts/bare-debian.sh
libraries=(libopencv-dev libturbojpeg0-dev libpng-dev libheif-dev libopenexr-dev liblcms2-dev libhwy-dev zlib1g-dev
           libexpat1-dev nlohmann-json3-dev libavformat-dev libavcodec-dev libavutil-dev libswscale-dev
           libswresample-dev libavdevice-dev libgtest-dev)
scripts/install-dependencies.sh arm64
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
mirror=$(debian_mirror "$suite")
place=$(mktemp -d)
trap 'rm -rf -- "$place"' EXIT
chmod 755 "$place" # apt drops to a user of its own

# Makes $root, a folder with packages and what they depend on. @param its name, the packages
unpack() {
    root=$place/$1
    shift
    echo "== packages for arm64 in $root"
    mkdir -p "$root"/usr/{bin,lib,sbin} "$root"/apt/lists/partial "$root"/apt/archives/partial
    for folder in bin lib sbin; do ln -s "usr/$folder" "$root/$folder"; done
    : >"$root/apt/status"
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror $suite main" >"$root/apt/sources.list"
    local apt=(apt-get -q -y -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o APT::Install-Recommends=false
        -o Dir::State="$root/apt" -o Dir::State::status="$root/apt/status" -o Dir::Cache="$root/apt"
        -o Dir::Etc::sourcelist="$root/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null)
    "${apt[@]}" update >"$root/apt/log"
    "${apt[@]}" --download-only install "$@" >>"$root/apt/log"
    local package
    for package in "$root"/apt/archives/*.deb $(printf '%s\n' "$@" | grep '\.deb$'); do
        dpkg-deb --fsys-tarfile "$package" | tar -x -C "$root" --keep-directory-symlink
    done
    found=$root/usr/lib/aarch64-linux-gnu
    ln -s blas/libblas.so.3 lapack/liblapack.so.3 "$found/" # as update-alternatives does
}

unpack libraries "${libraries[@]}"
echo "== unit tests for arm64"
export PKG_CONFIG_SYSROOT_DIR=$root PKG_CONFIG_LIBDIR=$found/pkgconfig:$root/usr/share/pkgconfig
cmake --fresh --preset dev -B build/arm64 -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
    -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DCMAKE_SYSROOT="$root" \
    -DCMAKE_FIND_ROOT_PATH_MODE_{LIBRARY,INCLUDE,PACKAGE}=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER \
    -DCMAKE_CROSSCOMPILING_EMULATOR="qemu-aarch64;-L;$root" \
    -DALTIRO3D_BUILD_QT=OFF -DALTIRO3D_BUILD_TOOLS=OFF -DALTIRO3D_BUILD_BENCHMARKS=OFF
cmake --build build/arm64 --target altiro3D altiro3D_unit_tests
ALTIRO3D_LONGEST_TEST=0.5 ctest --test-dir build/arm64 -j "$(nproc)" --output-on-failure -L unit

shopt -s nullglob
packages=(build/package-arm64/altiro3d_*.deb build/package-arm64/libaltiro3d[0-9]*.deb)
if [[ ${#packages[@]} -eq 0 ]]; then
    scripts/make-packages.sh --arch arm64
    packages=(build/package-arm64/altiro3d_*.deb build/package-arm64/libaltiro3d[0-9]*.deb)
fi
unpack bare "${packages[@]/#/./}"
photo=(--fit cover -d docs/examples/sample.jpg docs/examples/sample-depth.png)
qemu-aarch64 -L "$root" "$root/usr/bin/photo2native" "${photo[@]}" "$place/arm64.png"
"$build/tools/photo2native" "${photo[@]}" "$place/here.png"
cmp "$place/arm64.png" "$place/here.png"
echo "the Native of the sample photo has the bytes of $build"
