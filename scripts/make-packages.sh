#!/usr/bin/env bash
# Makes the Debian packages in build/package/ and checks them with lintian.
#
#   scripts/make-packages.sh [-DALTIRO3D_PACKAGE_CONTACT="NAME <MAIL>"]    the contact of the packages
#   scripts/make-packages.sh --arch arm64 [-D...]    the packages for Debian 12 on arm64, in build/package-arm64/
#
# Those for arm64 are compiled in a temporary Debian with the libraries of both architectures, which needs root,
# the network (450 MB) and 2.5 GB of disk. Manual pages are those of the build for this machine.
#
# Uses the build of scripts/quickstart.sh if it exists. One source file holds the place of the data: it is
# compiled for /usr, and at the end again for the source tree.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
arch=
if [[ ${1:-} == --arch ]]; then
    [[ ${2:-} == arm64 ]] || wrong_usage "--arch ${2:-}: unknown, expected arm64"
    arch=arm64
    shift 2
fi
for argument; do
    [[ $argument == -D?* ]] || check_arguments 0 -- "$argument"
done
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh package
if [[ -z ${SOURCE_DATE_EPOCH:-} ]] && when=$(git log -1 --format=%ct 2>/dev/null); then
    export SOURCE_DATE_EPOCH=$when # the same source gives the same packages
fi
export NINJA_STATUS='[%f/%t, %p, %e s] ' # done, of all, share, time
umask 022

# Tags of lintian that are suppressed:
#   initial-upload-closes-no-bugs       no bug asks for the package
#   maintscript-calls-ldconfig          CPack's own scripts, next to the trigger
#   library-not-linked-against-libc     libaltiro3D-imgcodecs calls nothing but OpenCV
accepted=initial-upload-closes-no-bugs,maintscript-calls-ldconfig,library-not-linked-against-libc
check_made() { # folder
    echo "Checking the packages"
    lintian --allow-root --fail-on error,warning --suppress-tags "$accepted" "$1"/*.deb
    echo "packages:" "$1"/*.deb
}

back_to_source() {
    local status=$?
    [[ -z ${root:-} ]] || remove_root
    echo "Building again what differs for the source tree"
    cmake --preset package "$@" >/dev/null && cmake --build --preset package || status=1
    exit "$status"
}
trap 'back_to_source "$@"' EXIT
cmake --preset deb "$@"
cmake --build --preset deb
if [[ -n $arch ]]; then
    # shellcheck source=scripts/bare-debian.sh
    . scripts/bare-debian.sh
    make_root bookworm
    trap 'back_to_source "$@"' EXIT
    mount -t proc proc "$root/proc" # the tools of the build read it
    mkdir "$root/source"
    tar -c --exclude=./build --exclude=./.git . | tar -x -C "$root/source" --no-same-owner
    cp -r build/package/tools/manual "$root/"
    echo "== libraries for $arch"
    inside "dpkg --add-architecture $arch; { apt-get -q update && ALTIRO3D_LOG=/apt /source/scripts/install-dependencies.sh \
        package-$arch; } >/log 2>&1 || { cat /apt /log; exit 1; }"
    echo "== packages for $arch"
    folder=/source
    options=
    [[ $# -eq 0 ]] || printf -v options '%q ' "$@"
    inside "export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-} PKG_CONFIG=aarch64-linux-gnu-pkg-config DEB_HOST_ARCH=$arch
        cmake --preset deb -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
            -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
            -DCMAKE_INSTALL_LIBDIR=lib/aarch64-linux-gnu \
            -DALTIRO3D_MANUAL_DIR=/manual -DCPACK_DEBIAN_PACKAGE_ARCHITECTURE=$arch $options
        cmake --build --preset deb
        cpack --config build/package/CPackConfig.cmake -B build/package"
    rm -rf "build/package-$arch"
    mkdir -p "build/package-$arch"
    cp "$root"/source/build/package/*.deb "build/package-$arch/"
    check_made "build/package-$arch"
    exit 0
fi

rm -f build/package/*.deb
cpack --config build/package/CPackConfig.cmake -B build/package
check_made build/package
