#!/usr/bin/env bash
# Makes the archive for any Linux, and tries it on bare Debian 12 and 13, which have no library of it. Needs
# root, debootstrap, the network and some minutes.
#
#   scripts/check-archive.sh [--made]    --made: takes the archive that is in build/archive/
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 --made -- "$@"
cd "$(dirname "$0")/.."
. scripts/bare-debian.sh
[[ ${1:-} == --made ]] || scripts/make-archive.sh
archive=$(echo build/archive/*.tar.xz)

try() { # suite
    make_root "$1"
    mount -t proc proc "$root/proc"
    mkdir "$root/made"
    tar --extract --file "$archive" --directory "$root/made" --strip-components 1
    cp docs/examples/sample.jpg "$root/made/"
    folder=/made
    inside 'for tool in bin/*; do [[ $tool == *.conf ]] || "$tool" --version >/dev/null; done'
    inside 'bin/photo2native --save-quilt quilt.png sample.jpg native.png 2>&1
        bin/quilt2video --seconds 0.5 --turns 1 --fps 8 quilt_qs8x6a0.75.png sway.mp4
        bin/video2native sway.mp4 native.mkv
        bin/photo2native --save-depth depth.png sample.jpg native.tif 2>&1'
    inside 'export QT_QPA_PLATFORM=offscreen; bin/altiro3Dview --list-displays'
    sha256sum <"$root/made/native.png" | tee "build/archive/native-$1.sum"
    remove_root
    trap - EXIT
}
try bookworm
try trixie
cmp build/archive/native-{bookworm,trixie}.sum
echo "the archive is good: used on bare Debian 12 and 13, with the same bytes"
