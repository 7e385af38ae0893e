#!/usr/bin/env bash
# Makes the pictures of the README from the sample photo with the tools (needs ImageMagick).
#
#   docs/make-pictures.sh [DIRECTORY OF THE TOOLS]
set -euo pipefail
cd "$(dirname "$0")/.."
tools=${1:-build/dev/tools}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sample=docs/examples/sample
"$tools/photo2native" -c calibration/portrait-sample.json -d --save-quilt "$work/quilt.png" \
    "$sample.jpg" "$sample-depth.png" "$work/native.png"
mkdir -p docs/images
convert "$sample.jpg" -resize 400x -quality 88 docs/images/photo.jpg
convert "$sample-depth.png" -depth 8 -resize 400x docs/images/depth.png
convert "$work"/quilt_qs*.png -resize 400x533! -quality 85 docs/images/quilt.jpg
# pixel for pixel, from the middle: a Native that is scaled is none
convert "$work/native.png" -gravity center -crop 400x533+0+200 +repage docs/images/native.png
# the same depth edge by each method, outermost view, three times enlarged
for method in fast real layered; do
    "$tools/photo2native" -c calibration/portrait-sample.json -d --method "$method" --strength 14 \
        --save-views "$work/$method" "$sample.jpg" "$sample-depth.png" "$work/$method.png"
    convert "$work/$method/view_47.png" -crop 100x110+25+175 +repage -filter point -resize 300% \
        "docs/images/$method.png"
done
