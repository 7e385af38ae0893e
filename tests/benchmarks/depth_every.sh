#!/usr/bin/env bash
# What fewer inferences cost and save in whole videos: PSNR of the Natives against --depth-every 1,
# and the time of the depth stage per frame. Prints a row of docs/lab/video.md per clip.
#
#   depth_every.sh VIDEO2NATIVE NETWORK CLIP...
set -euo pipefail
tool=$1 network=$2
shift 2
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
value() { python3 -c 'import json,sys; r = json.load(open(sys.argv[1])); print(eval(sys.argv[2]))' "$@"; }
for clip in "$@"; do
    row="| $(basename "${clip%.*}")"
    for every in 1 2 4 8 auto; do
        "$tool" -y --no-audio --codec ffv1 --preview 6 --depth-every $every -n "$network" \
            --report "$place/r.json" "$clip" "$place/$every.mkv" >/dev/null 2>&1
        cost=$(value "$place/r.json" '"%.0f ms, %.0f %%" % (
            [s for s in r["stages"] if s["name"] == "depth"][0]["millisecondsPerFrame"],
            100 * r["inferences"] / r["frames"])')
        quality=-
        if [[ $every != 1 ]]; then
            quality=$(ffmpeg -nostdin -hide_banner -i "$place/$every.mkv" -i "$place/1.mkv" \
                -lavfi psnr -f null - 2>&1 | sed -n 's/.*average:\([0-9.inf]*\).*/\1/p')
            rm "$place/$every.mkv"
        fi
        row+=" | $quality ($cost)"
    done
    echo "$row |"
done
