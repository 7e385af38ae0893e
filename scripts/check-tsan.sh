#!/usr/bin/env bash
# Runs the unit tests of up to 2 s, the viewer's tests and video2native with all of its threads under
# ThreadSanitizer. Any data race fails.
#
# Runs on one processor, so that OpenCV's pool (TBB, not instrumented) starts no threads. The tests that
# compare numbers of threads check that rows are independent. tests/tsan.supp leaves out other libraries;
# tests/qt/tsan_events.cpp declares how Qt's events order threads.
#
#   scripts/check-tsan.sh
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
[[ -f build/tsan/build.ninja ]] || cmake --preset tsan >/dev/null
cmake --build --preset tsan --target altiro3D_unit_tests altiro3D_qt_tests video2native
work=$(mktemp -d)
# Writes reports to files, because tools silence standard error while other libraries read.
export TSAN_OPTIONS="suppressions=$PWD/tests/tsan.supp history_size=4 log_path=$work/report"
trap 'cat "$work"/report.* 2>/dev/null || true; rm -rf -- "$work"' EXIT
export XDG_CACHE_HOME=$work/cache XDG_DATA_HOME=$work/data
cpu=$(taskset -cp $$ | sed 's/.*: *\([0-9]*\).*/\1/')

echo "== ThreadSanitizer: library"
# The child of the test that is left out reads freed memory of OpenCV, as it should.
ALTIRO3D_LONGEST_TEST=2 taskset -c "$cpu" build/tsan/tests/unit/altiro3D_unit_tests --gtest_brief=1 \
    --gtest_filter=-DepthNetworkFile.AProbeSurvivesFilesThatCrashOpenCv

echo "== ThreadSanitizer: viewer"
taskset -c "$cpu" build/tsan/tests/qt/altiro3D_qt_tests --gtest_brief=1

echo "== ThreadSanitizer: video2native"
ffmpeg -nostdin -v error -f lavfi -i testsrc2=size=64x48:rate=10:duration=1 \
    -f lavfi -i sine=duration=1 -c:v libx264 -pix_fmt yuv420p -c:a aac "$work/clip.mp4"
python3 - calibration/portrait-sample.json "$work/small.json" <<'PYTHON'
import json, sys
display = json.load(open(sys.argv[1]))
display["serial"] = "TEST"
display["screenW"]["value"], display["screenH"]["value"] = 96, 128
json.dump(display, open(sys.argv[2], "w"))
PYTHON
convert() { # options, input
    taskset -c "$cpu" build/tsan/tools/video2native -q 2x3 -r 40x30 -c "$work/small.json" "$@" "$work/out.mkv"
}
for more in "" "--preview 1" --quilt-out --rgbd-out; do
    # shellcheck disable=SC2086 # several arguments
    convert -y $more "$work/clip.mp4" >/dev/null
done
# A run that is killed after its first segment, and a run that continues it.
ffmpeg -nostdin -v error -stream_loop 19 -i "$work/clip.mp4" -c copy "$work/long.mp4"
rm "$work/out.mkv"
convert "$work/long.mp4" >/dev/null &
while [[ ! -e $work/out.mkv.parts/000002.mp4 ]]; do
    kill -0 $! # else it has ended before
    sleep 0.05
done
pkill -KILL -f "$work/out.mkv"
wait $! || true
convert --resume "$work/long.mp4" | grep "continues at"
if compgen -G "$work/report.*" >/dev/null; then # the run that was killed cannot say so itself
    echo "ThreadSanitizer: FAILED"
    exit 1
fi
