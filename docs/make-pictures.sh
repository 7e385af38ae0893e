#!/usr/bin/env bash
# Makes pictures of the README, the guide and docs/depth.md with the tools (needs ImageMagick).
#
#   docs/make-pictures.sh [DIRECTORY OF THE TOOLS]
#
# $ALTIRO3D_TEST_DATA (default: ../shared/data) has photos of others and FastDepth; without it docs/depth.md keeps
# its picture.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/../scripts/usage.sh"
check_arguments 1 -- "$@"
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

# a pitch sheet under lenses of 60.075 LPI: the band of that pitch, and one four steps from it
"$tools/altiro3Dnative" --lens lpi=60,dpi=720,size=100x100mm --pitch-sheet "$work/pitch.png" >"$work/said"
"$tools/altiro3Dnative" --lens lpi=60.075,dpi=720,size=100x100mm "$work/lens.json" >>"$work/said"
"$tools/native2view" -c "$work/lens.json" --angle 5 "$work/pitch.png" "$work/seen.png" >>"$work/said"
for band in right:11 wrong:15; do # of 21, above a line of text
    y=$(identify -format "%[fx:(h-170)/21*${band#*:}]" "$work/seen.png")
    convert "$work/seen.png" -crop "2835x126+0+${y%.*}" +repage -resize 720x \
        "docs/images/pitch-${band%:*}.png"
done

# photo | altiro3d | FastDepth, all colour photos of two public collections
data=${ALTIRO3D_TEST_DATA:-../shared/data}
fastdepth=$data/models/fastdepth/fastdepth_224_op10.onnx
if [[ ! -f $fastdepth ]]; then
    echo "$0: $fastdepth: is missing, expected the test data; docs/images/depth-sources.jpg stays" >&2
    exit
fi
rows=()
for photo in "$data"/photos/kodak/kodim*.png "$data"/photos/skimage/{astronaut,chelsea,coffee}.png \
    "$data"/photos/skimage/rocket.jpg; do
    row=$work/row-$(basename "${photo%.*}").png
    tiles=()
    for network in altiro3d "$fastdepth"; do
        ALTIRO3D_MODELS=models "$tools/photo2native" -y -c calibration/portrait-sample.json -n "$network" \
            --save-depth "$work/depth.png" "$photo" "$work/native.png"
        if [[ ${#tiles[@]} -eq 0 ]]; then # cut as the tools cut it to the panel
            convert "$photo" -resize 120x160^ -gravity center -extent 120x160 "$work/tile0.png"
            tiles=("$work/tile0.png")
        fi
        convert "$work/depth.png" -depth 8 -resize 120x160! "$work/tile${#tiles[@]}.png"
        tiles+=("$work/tile${#tiles[@]}.png")
    done
    convert "${tiles[@]}" +append "$row"
    rows+=("$row")
done
half=$(((${#rows[@]} + 1) / 2))
convert \( "${rows[@]:0:half}" -append \) \( "${rows[@]:half}" -append \) -background white +smush 12 -quality 85 \
    docs/images/depth-sources.jpg
