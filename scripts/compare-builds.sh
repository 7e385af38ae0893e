#!/usr/bin/env bash
# Compares builds with each other, and the first build with itself on one thread and with each lower
# instruction set that Highway supports on this processor. Look-up tables, views, quilts, refined depth
# and Natives (PNG and video) must have the same bytes.
#
#   scripts/compare-builds.sh build/dev [build/clang]
#
# Videos are compared frame by frame: containers name the program that wrote them. Videos of
# ../shared/data and its small depth network are compared as well if they exist.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 2 -- "$@"
cd "$(dirname "$0")/.."
if [[ $# -lt 1 || ! -x $1/tools/photo2native ]]; then
    wrong_usage "${1:-no build}: holds no tools/photo2native, expected a directory in which altiro3D was built"
fi
first=$(realpath "$1")
work=$(mktemp -d "${TMPDIR:-/tmp}/altiro3D-compare-XXXXXX")
trap 'rm -rf "$work"' EXIT
unset LKG_CALIBRATION
display=(-c "$PWD/calibration/portrait-sample.json")
small=(-c "$work/small.json" -r 162x121) # for videos, which would take minutes
sed 's/1536/388/; s/2048/516/' "${display[1]}" >"$work/small.json"
photo=$PWD/docs/examples/sample.jpg
depth=$PWD/docs/examples/sample-depth.png
network=$PWD/../shared/data/models/fastdepth/fastdepth_224_op10.onnx
bikes=$PWD/../shared/data/videos/bikes.mp4 # a hard cut at 1.2 s

# A camera that moves over the sample, with its depth: needs nothing but ffmpeg.
for of in photo depth; do
    ffmpeg -v error -loop 1 -i "${!of}" -frames:v 8 -c:v ffv1 -pix_fmt \
        "$([[ $of == photo ]] && echo yuv444p || echo gray)" \
        -vf "crop=240:320:x='100+6*n':y='40+3*n',fps=25" "$work/$of.mkv"
done

# Runs a tool of $tools in $out; what it says matters only if it fails.
run() {
    local tool=$1
    shift
    if ! XDG_CACHE_HOME=$out.cache "${within[@]}" "$tools/$tool" "$@" >"$work/said" 2>&1; then
        cat "$work/said" >&2
        echo "$0: $tool $*: failed" >&2
        exit 1
    fi
}
# video NAME ARGUMENTS...: of video2native; leaves the checksums of the frames.
video() {
    local name=$1 file=$work/$1.mkv
    shift
    run video2native "${small[@]}" --codec ffv1 "$@" "$file"
    set -- "$work/$name"*.mkv # that of a quilt tells its layout
    ffmpeg -v error -i "$1" -map 0:v -f framemd5 "$out/$name.framemd5"
    rm "$1"
}
# All that is compared, by the tools of a build: BUILD DIRECTORY [COMMAND that runs them...]
make_all() {
    tools=$1/tools
    out=$2
    within=(env "${@:3}")
    mkdir "$out"
    local given=(-d "$photo" "$depth")
    run altiro3Dnative -m "$out/a.map" "${display[@]:1}"
    run photo2native "${display[@]}" --save-quilt "$out/quilt.png" --save-views "$out/views" \
        --save-depth "$out/depth.png" "${given[@]}" "$out/native.png"
    run photo2native "${display[@]}" -k --continuous "${given[@]}" "$out/best.png"
    run photo2native "${display[@]}" --method fast "${given[@]}" "$out/fast.png"
    run photo2native "${display[@]}" -g "${given[@]}" "$out/real.png"
    run quilt2native "${display[@]}" --sampling linear --view-filter linear \
        "$out/quilt_qs8x6a0.75.png" "$out/linear.png"
    video given --depth "$work/depth.mkv" "$work/photo.mkv"
    video quilt --quilt-out --to 0.08 --depth "$work/depth.mkv" "$work/photo.mkv"
    if [[ -f $bikes ]]; then
        video bikes --depth "$bikes" --from 1 --to 1.5 "$bikes"
        [[ ! -f $network ]] ||
            ALTIRO3D_MODELS=$PWD/models video network -n "$network" --from 1 --to 1.5 "$bikes"
    fi
}
same() { # DIRECTORY, what it holds
    diff -r "$work/first" "$work/$1"
    echo "the same bytes: $2"
    rm -r "${work:?}/$1"
}

make_all "$first" "$work/first"
[[ -f $bikes ]] || echo "not there: $bikes, so no video is compared but the one made of the sample"
[[ -f $network ]] || echo "not there: $network, so no video by a network is compared"

if [[ $# -gt 1 ]]; then
    make_all "$(realpath "$2")" "$work/second"
    same second "$2"
fi
make_all "$first" "$work/one" taskset -c "$(taskset -cp $$ | sed 's/.*: //; s/[-,].*//')"
same one "$1, one processor"

limit=$first/tests/libaltiro3D_highway_limit.so
if [[ ! -f $limit ]]; then # what cannot be preloaded is passed over
    echo "$limit: is not there, expected a build with tests" >&2
    exit 1
fi
for ((leave_out = 1; ; ++leave_out)); do
    lesser=(HIGHWAY_LEAVE_OUT="$leave_out" LD_PRELOAD="$limit")
    status=0
    env "${lesser[@]}" true || status=$?
    [[ $status != 99 ]] || break
    [[ $status == 0 ]] || exit 1
    make_all "$first" "$work/lesser" "${lesser[@]}"
    same lesser "$1 without the best $leave_out instruction set(s)"
done
