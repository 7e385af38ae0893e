#!/usr/bin/env bash
# Runs the tools of build/dev once under valgrind (memcheck) on small inputs. Fails if they use memory that
# is not allocated or not initialized, if they leak memory, or if their outputs differ from those without
# valgrind. valgrind does not support AVX-512, so Highway's kernels for AVX2 run.
#
#   scripts/check-valgrind.sh [TOOLS]       TOOLS: directory of the tools (default: build/dev/tools)
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"
cd "$(dirname "$0")/.."
tools=$(cd "${1:-build/dev/tools}" && pwd)
sample=$PWD/calibration/portrait-sample.json
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd "$work"
export XDG_CACHE_HOME=$work/cache XDG_DATA_HOME=$work/data
mkdir plain checked
python3 - "$sample" <<'PYTHON'
import json, sys
display = json.load(open(sys.argv[1]))
display["serial"] = "TEST"
display["screenW"]["value"], display["screenH"]["value"] = 96, 128
json.dump(display, open("small.json", "w"))
PYTHON
ffmpeg -nostdin -v error -f lavfi -i testsrc2=size=90x120 -frames:v 1 photo.jpg
ffmpeg -nostdin -v error -f lavfi -i testsrc2=size=64x48:rate=10:duration=1 \
    -f lavfi -i sine=duration=1 -c:v libx264 -pix_fmt yuv420p -c:a aac clip.mp4

failures=0
# check TOOL OUTPUT ARGUMENT...: OUT stands for the directory of the output
check() {
    local tool=$1 output=$2 log=$work/$1-$2.log
    shift 2
    "$tools/$tool" -y -j 1 "${@//OUT/plain}" >"$log" 2>&1 || { cat "$log" && exit 1; }
    if ! valgrind --quiet --error-exitcode=77 --leak-check=full --errors-for-leak-kinds=definite \
        --show-leak-kinds=definite --num-callers=30 --log-file="$log" \
        "$tools/$tool" -y -j 1 "${@//OUT/checked}" >"$log.said" 2>&1; then
        failures=$((failures + 1))
        echo "valgrind: $tool: FAILED"
        cat "$log.said" "$log"
    elif ! cmp "plain/$output" "checked/$output"; then
        failures=$((failures + 1))
        echo "valgrind: $tool: writes something else than without valgrind"
    else
        echo "valgrind: $tool, $output: clean"
    fi
}
quilt=(-c small.json -q 2x3 -r 40x30)
check altiro3Dnative a.map -q 2x3 -r 40x30 small.json -m OUT/a.map
check photo2native n.png "${quilt[@]}" photo.jpg OUT/n.png
check photo2native q_qs3x2a0.75.png "${quilt[@]}" -g photo.jpg OUT/g.png --save-quilt OUT/q.png
check photo2native k.png "${quilt[@]}" -k --continuous photo.jpg OUT/k.png
check quilt2native n.png -c small.json plain/q_qs3x2a0.75.png OUT/n.png
check native2view v.png -c small.json plain/n.png OUT/v.png
check video2native v.mkv "${quilt[@]}" --codec ffv1 clip.mp4 OUT/v.mkv
exit $((failures > 0))
