#!/usr/bin/env bash
# Runs the README's two commands on a bare Debian, in a clone of what is committed: everything that is
# needed must come by the scripts. Needs root, debootstrap, the network and half an hour.
#
#   scripts/check-fresh.sh [SUITE]    bookworm (Debian 12, default) or trixie (Debian 13)
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"
cd "$(dirname "$0")/.."
. scripts/bare-debian.sh
[[ ${1:-bookworm} =~ ^(bookworm|trixie)$ ]] || wrong_usage "$1: unknown suite, expected bookworm or trixie"
make_root "${1:-bookworm}"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --make-rslave "$root/dev"
mount -t tmpfs tmpfs "$root/tmp"
git clone -q . "$root/altiro3D"
inside 'apt-get update -q >/dev/null'
folder=/altiro3D
inside scripts/quickstart.sh
inside scripts/test.sh
