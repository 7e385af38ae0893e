#!/usr/bin/env bash
# From nothing to a Native: installs packages, builds, and turns a photo into a picture for the
# display, its quilt and its depth.
#
#   scripts/quickstart.sh [PHOTO [visual.json]]
#
# Without a photo the sample is used; without a calibration the tools look for one.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
photo=docs/examples/sample.jpg
[[ $# -lt 1 ]] || photo=$(cd "$OLDPWD" && realpath -- "$1")
calibration=()
[[ $# -lt 2 ]] || calibration=(-c "$(cd "$OLDPWD" && realpath -- "$2")")
if [[ ! -f $photo ]]; then
    echo "$0: $photo does not exist, expected a photo" >&2
    exit 1
fi

scripts/install-dependencies.sh build
cmake --preset package
cmake --build --preset package

output=$root/quickstart-output
mkdir -p "$output"
build/package/tools/photo2native -y -v "${calibration[@]}" \
    --save-quilt "$output/quilt.png" --save-depth "$output/depth.png" \
    -- "$photo" "$output/native.png"
cp -f "$output/native.png" "$root/native.png"
echo
echo "Your pictures:"
echo "  $root/native.png   the Native, to be shown full screen, pixel for pixel, on the display"
echo "  $output/            the same with its quilt and its depth"
echo "The tools are in $root/build/package/tools; try photo2native --help"
