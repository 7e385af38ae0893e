#!/usr/bin/env bash
# Reports which lines of each reader its fuzz target has reached. Runs the inputs that scripts/fuzz.sh has
# gathered (build/fuzz/seeds and build/fuzz/corpus, or those below DIR) once, with Clang's coverage.
# Fails if less than 80 % of a reader's lines are reached.
#
#   scripts/fuzz-coverage.sh [DIR]
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"
cd "$(dirname "$0")/.."
inputs=${1:-build/fuzz}
build=build/fuzz-coverage
least=80 # %
declare -A seen=()
failed=0
cmake -S . -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -fprofile-instr-generate -fcoverage-mapping" \
    -DALTIRO3D_SANITIZE=fuzzer-no-link -DALTIRO3D_BUILD_FUZZERS=ON -DALTIRO3D_BUILD_TOOLS=OFF \
    -DALTIRO3D_BUILD_{QT,PYTHON,TESTS,BENCHMARKS}=OFF >/dev/null
cmake --build "$build" >/dev/null

# target, source, functions that are the reader (a regular expression of mangled names; '.': all),
# functions that are not ('-': none)
readers="
calibration     calibration      .                                     -
usb_memory      usb_memory       .                                     -
bridge_answers  bridge_answers   .                                     -
native_lut      native_lut       readAt|checkHeader|crcOf|4load        -
quilt           quilt            .                                     -
picture_header  image_format     .                                     -
picture_header  image_header     .                                     -
exif            exif             Exif|exif|rawProfile|validOrientation 4turn|7upright
heif            heif_boxes      .                                     -
colour          colour           .                                     HeifFile
embedded_depth  depth_parts      .                                     -
embedded_depth  xmp              .                                     -
picture         image_read       .                                     -
picture         rgbd             split|halves|isBeside                 -
camera          view_options     parseCamera|5check                    -
network_catalog network_profile  .                                     modelSearchPath|findModelFile
onnx_facts      onnx_facts       .                                     -
view_names      image_names      listImages|naturalLess|isDigit|isName -
video_run       resumable_video  readRun|segmentOf|wholeNumber|bitsOf|differ -
video_run       video_segments   SegmentReader|Shown|4join             4fail
depth_state     video_depth      8setState                             -
depth_state     motion           4load                                 -
depth_state     state_bytes      4take|checksum                        -
video           video_input      .                                     -
video           video_reader     .                                     otherStreams|pass|8validate
other_streams   video_packets    describeOthers|4keep|drainOthers      -
other_streams   video_reader     4pass                                 -
other_streams   other_streams    .                                     -
other_streams   video_container  .                                     canWriteVideo|canHold|markEyes|PartFile|check
"
suffix=$(clang++ --version | sed -n 's/.*version \([0-9]*\).*/-\1/p;q')
printf '%-16s %-18s %6s %8s %8s\n' target reader lines reached share
while read -r target source wanted others; do
    [[ -n $target ]] || continue
    profile=$build/$target
    if [[ ! -f $profile.profdata || -z ${seen[$target]:-} ]]; then
        directories=()
        for directory in "$inputs/seeds/$target" "$inputs/corpus/$target"; do
            [[ ! -d $directory ]] || directories+=("$directory")
        done
        LLVM_PROFILE_FILE=$profile.profraw "$build/tests/fuzz/${target}_fuzz" -runs=0 \
            -rss_limit_mb=4000 "${directories[@]}" >"$profile.log" 2>&1 ||
            { tail -5 "$profile.log" >&2 && exit 1; }
        "llvm-profdata$suffix" merge -sparse "$profile.profraw" -o "$profile.profdata"
        seen[$target]=1
    fi
    "llvm-cov$suffix" export -instr-profile="$profile.profdata" \
        "$build/tests/fuzz/${target}_fuzz" >"$profile.json"
    python3 - "$profile.json" "$target" "$source" "$wanted" "$others" "$least" <<'PYTHON' || failed=1
import json, re, sys
path, target, source, wanted, others, least = sys.argv[1:]
spans = {}  # of a function's first place: its lines and how often each ran; the most of all instances
for function in json.load(open(path))["data"][0]["functions"]:
    name = function["name"]
    if not function["filenames"][0].endswith("/" + source + ".cpp"): continue
    if not re.search(wanted, name) or (others != "-" and re.search(others, name)): continue
    counts = {}
    for first, _, last, _, count, file, _, kind in function["regions"]:  # outer ones come first
        if kind != 0 or file != 0: continue
        for line in range(first, last + 1):
            counts[line] = max(counts.get(line, 0), count) if line == first else count
    place = tuple(function["regions"][0][:4])
    before = spans.get(place, {})
    spans[place] = {line: max(count, before.get(line, 0)) for line, count in counts.items()}
lines = {}
for place in sorted(spans, key=lambda p: p[0] - p[2]):  # lambdas stand in longer functions
    lines.update(spans[place])
reached = sum(count > 0 for count in lines.values())
share = 100 * reached / max(len(lines), 1)
print(f"{target:16} {source:18} {len(lines):6} {reached:8} {share:7.1f}%", flush=True)
if share < float(least):
    sys.exit(f"fuzz-coverage: {target}: {share:.1f} % of the lines of {source}.cpp are reached, "
             f"expected {least} % or more")
PYTHON
done <<<"$readers"
exit "$failed"
