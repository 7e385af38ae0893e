#!/usr/bin/env bash
# Holds two builds against each other: look-up tables, quilts and Natives must have the same bytes.
#
#   scripts/compare-builds.sh build/dev build/clang
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for side in 1 2; do
    tools=${!side}/tools
    mkdir -p "$work/$side"
    XDG_CACHE_HOME=$work/$side/cache "$tools/altiro3Dnative" -m "$work/$side/a.map" \
        calibration/portrait-sample.json >/dev/null
    XDG_CACHE_HOME=$work/$side/cache "$tools/photo2native" -c calibration/portrait-sample.json \
        --save-quilt "$work/$side/quilt.png" \
        -d docs/examples/sample.jpg docs/examples/sample-depth.png "$work/$side/native.png" >/dev/null
    XDG_CACHE_HOME=$work/$side/cache "$tools/photo2native" -c calibration/portrait-sample.json \
        --save-depth "$work/$side/depth.png" \
        docs/examples/sample.jpg "$work/$side/native-cues.png" >/dev/null
    rm -rf "$work/$side/cache"
done
diff -r "$work/1" "$work/2"
echo "the two builds give the same bytes"
