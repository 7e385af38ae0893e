#!/usr/bin/env bash
# Makes the Debian packages in build/package/ and checks them with lintian.
#
#   scripts/make-packages.sh [-DALTIRO3D_PACKAGE_CONTACT="NAME <MAIL>"]    the contact of the packages
#
# Uses the build of scripts/quickstart.sh if it exists. One source file holds the place of the data: it is
# compiled for /usr, and at the end again for the source tree.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
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
back_to_source() {
    local status=$?
    echo "Building again what differs for the source tree"
    cmake --preset package "$@" >/dev/null && cmake --build --preset package || status=1
    exit "$status"
}
trap 'back_to_source "$@"' EXIT
cmake --preset deb "$@"
cmake --build --preset deb
rm -f build/package/*.deb
cpack --config build/package/CPackConfig.cmake -B build/package

# Tags of lintian that are suppressed:
#   initial-upload-closes-no-bugs       no bug asks for the package
#   maintscript-calls-ldconfig          CPack's own scripts, next to the trigger
#   library-not-linked-against-libc     libaltiro3D-imgcodecs calls nothing but OpenCV
accepted=initial-upload-closes-no-bugs,maintscript-calls-ldconfig,library-not-linked-against-libc
echo "Checking the packages"
lintian --allow-root --fail-on error,warning --suppress-tags "$accepted" build/package/*.deb
echo "packages:" build/package/*.deb
