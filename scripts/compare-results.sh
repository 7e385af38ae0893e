#!/usr/bin/env bash
# Compares what the tools of two builds write: the same commands must give the same bytes.
#
#   scripts/compare-results.sh BUILD_A BUILD_B      as build/dev, with the tools in tools/
#
# Runs each command once with either build on the sample photo, its quilt, its views and a short clip.
# Prints the commands whose outputs differ, and fails if there are any.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 2 -- "$@"
[[ $# -eq 2 ]] || wrong_usage "there are $# builds, expected two"
source=$(cd "$(dirname "$0")/.." && pwd)
builds=()
for build in "$@"; do
    [[ -x $build/tools/photo2native ]] ||
        { echo "$build: holds no tools/photo2native, expected a build of altiro3D" >&2; exit 2; }
    builds+=("$(cd "$build" && pwd)/tools")
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work"/{a,b,inputs}
unset LKG_CALIBRATION ALTIRO3D_MODELS
export XDG_DATA_HOME=$work/none
count=0
differing=0

# The outputs of a command lie in out/ of the folder it runs in; ../inputs holds what it reads.
compare() { # TOOL ARGUMENT...
    local side number=0 status=(0 0)
    for side in a b; do
        rm -rf "${work:?}/$side/out"
        mkdir "$work/$side/out"
        (cd "$work/$side" && XDG_CACHE_HOME=$work/$side/cache "${builds[number]}/$1" "${@:2}") \
            >"$work/$side/said" 2>&1 || status[number]=$?
        number=$((number + 1))
    done
    count=$((count + 1))
    if [[ ${status[0]} -ne 0 || ${status[1]} -ne 0 ]]; then
        echo "fails (${status[*]}): $*"
        sed 's/^/    /' "$work/a/said" "$work/b/said"
    elif ! diff -rq "$work/a/out" "$work/b/out" >"$work/differences"; then
        echo "differs: $*"
        sed 's/^/    /' "$work/differences"
    else
        return 0
    fi
    differing=$((differing + 1))
}

# Keeps outputs of the last command as inputs for others.
keep() { # NAME NEW_NAME
    cp -r "$work/a/out/$1" "$work/inputs/$2"
}

cp "$source/docs/examples/sample.jpg" "$source/docs/examples/sample-depth.png" "$work/inputs/"
cp "$source/calibration/portrait-sample.json" "$work/inputs/visual.json"
display=(-c ../inputs/visual.json)
small=("${display[@]}" -q 3x4 -r 280x210)
photo=(-d ../inputs/sample.jpg ../inputs/sample-depth.png)
sway=(--seconds 0.4 --fps 10 --turns 1)

compare altiro3Dnative -m out/portrait.map ../inputs/visual.json
keep portrait.map portrait.map
compare altiro3Dnative -m out/small.map -q 3x4 -r 280x210 ../inputs/visual.json

for method in fast real layered; do
    compare photo2native "${display[@]}" --method $method "${photo[@]}" out/native.png
    compare photo2native -m ../inputs/portrait.map --method $method "${photo[@]}" out/native.png
    compare photo2native "${small[@]}" --method $method -k --fit contain --focus 0.3 --strength 7 \
        --save-quilt out/quilt.png "${photo[@]}" out/native.png
done
for options in -k --continuous "-k --continuous" "--view-filter linear" "--sampling linear" \
    "-k --view-filter linear --sampling linear" "--fit contain" "--fit stretch" "--invert on" \
    "--invert off" "--depth-kind far-white" "--depth-kind metric" "--method fast --refine 3" \
    "--fill continue" "--borders hard" "-g --inpaint-from behind"; do
    # shellcheck disable=SC2086
    compare photo2native "${display[@]}" $options "${photo[@]}" out/native.png
done
compare photo2native "${display[@]}" ../inputs/sample.jpg out/native.png
compare photo2native "${display[@]}" "${sway[@]}" --save-depth out/depth.png \
    --save-rgbd out/rgbd.png --save-views out/views --save-quilt out/quilt.png --lg out/sway.mp4 \
    "${photo[@]}" out/native.png
keep quilt_qs8x6a0.75.png quilt_qs8x6a0.75.png
keep quilt_qs8x6a0.75.png quilt.png
keep views views
keep rgbd.png rgbd.png
keep native.png native.png
compare photo2native "${display[@]}" --rgbd right ../inputs/rgbd.png out/native.png
compare photo2native "${display[@]}" "${sway[@]}" --size 320x180 --fit contain --lg out/sway.mp4 \
    "${photo[@]}" out/native.png
compare photo2native "${display[@]}" --save-quilt out/wide_qs8x6a1.5.png "${photo[@]}" out/native.png
keep wide_qs8x6a1.5.png wide_qs8x6a1.5.png

for options in "" "--view-filter linear" "--sampling linear" "--fit contain" "--fit cover"; do
    # shellcheck disable=SC2086
    compare quilt2native "${display[@]}" $options ../inputs/quilt_qs8x6a0.75.png out/native.png
done
compare quilt2native -m ../inputs/portrait.map ../inputs/quilt.png out/native.png
compare quilt2native "${display[@]}" "${sway[@]}" --lg out/sway.mp4 ../inputs/wide_qs8x6a1.5.png \
    out/native.png
compare views2native "${display[@]}" --save-quilt out/quilt.png ../inputs/views out/native.png
compare views2native -m ../inputs/portrait.map --reverse ../inputs/views out/native.png
compare views2native "${small[@]}" --fit contain ../inputs/views out/native.png
compare slide2native "${display[@]}" --save-quilt out/quilt.png --save-depth out/depth.png ../inputs/views out/native.png
compare photo2native --save-page out/page.html "${photo[@]}"
compare quilt2native "${display[@]}" --save-page out/page.html ../inputs/wide_qs8x6a1.5.png
compare photo2native --save-splats out/scan.ply --splat-side 100 --splat-camera "${photo[@]}"
keep scan.ply scan.ply
compare splat2native "${display[@]}" --save-quilt out/quilt.png --save-depth out/depth.png ../inputs/scan.ply out/native.png
compare slide2native "${display[@]}" --method nearest --turntable ../inputs/views out/native.png
compare native2view "${display[@]}" --angle 10 ../inputs/native.png out/seen.png
compare native2view "${display[@]}" --eye ../inputs/native.png out/seen.png

compare quilt2video "${sway[@]}" ../inputs/quilt_qs8x6a0.75.png out/clip.mp4
keep clip.mp4 clip.mp4
mkdir "$work/inputs/depths"
cp "$work/inputs/sample-depth.png" "$work/inputs/depths/1.png"
clip=(--depth ../inputs/depths ../inputs/clip.mp4)
for options in "" "--method fast" "-g" "-k --continuous" "-m ../inputs/portrait.map" "--view-filter linear" \
    "--fit contain"; do
    # shellcheck disable=SC2086
    compare video2native "${display[@]}" $options "${clip[@]}" out/native.mp4
done
compare video2native "${small[@]}" ../inputs/clip.mp4 out/native.mkv
compare video2native "${small[@]}" --quilt-out "${clip[@]}" out/quilt.mp4
compare video2native "${small[@]}" --rgbd-out "${clip[@]}" out/rgbd.mp4

echo "$count commands compared, $differing differ"
[[ $differing -eq 0 ]]
