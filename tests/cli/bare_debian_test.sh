#!/usr/bin/env bash
# The mirror for a bare Debian comes from the sources of apt, in both formats, or from $DEBIAN_MIRROR.
# usage: bare_debian_test.sh SOURCE_DIRECTORY
set -uo pipefail
source=$1
command -v apt-get >/dev/null || { echo "skipped: needs apt-get"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
unset DEBIAN_MIRROR

expect_mirror() { # what, suite, mirror
    local found
    found=$(bash -euo pipefail -c '. "$0/scripts/bare-debian.sh"; debian_mirror "$1"' "$source" "$2" \
        2>"$work/message")
    [[ $found == "$3" ]] && return
    failures=$((failures + 1))
    echo "FAILED: $1: found '$found', expected '$3'; $(cat "$work/message")"
}

mkdir "$work/parts"
cat >"$work/apt.conf" <<TEXT
Dir::Etc::sourcelist "$work/sources.list";
Dir::Etc::sourceparts "$work/parts";
TEXT
export APT_CONFIG=$work/apt.conf

cat >"$work/sources.list" <<'TEXT'
# deb http://commented.invalid/debian bookworm-updates main
deb https://programs.invalid/browser bookworm main
deb [arch=amd64 trusted=yes] http://line.invalid/debian/ bookworm main contrib # ours
deb http://line.invalid/debian bookworm-updates main
deb http://line.invalid/debian-security bookworm-security main
TEXT
expect_mirror "one-line format" bookworm http://line.invalid/debian
DEBIAN_MIRROR=http://named.invalid/d expect_mirror "DEBIAN_MIRROR" bookworm http://named.invalid/d

: >"$work/sources.list"
cat >"$work/parts/some.sources" <<'TEXT'
Types: deb
Enabled: no
URIs: http://disabled.invalid/debian
Suites: trixie trixie-updates
Components: main

Types: deb deb-src
URIs: https://blocks.invalid/mirror/debian/
Suites: trixie
 trixie-updates
Components: main
TEXT
expect_mirror "deb822 format" trixie https://blocks.invalid/mirror/debian

rm "$work/parts/some.sources"
echo 'deb http://programs.invalid/browser bookworm main' >"$work/parts/some.list"
expect_mirror "no archive of Debian's" bookworm ""
grep -q "apt's sources: no Debian archive with bookworm, expected one there or in DEBIAN_MIRROR" \
    "$work/message" || { failures=$((failures + 1)); echo "FAILED: message: $(cat "$work/message")"; }

((failures == 0)) && echo "all passed"
