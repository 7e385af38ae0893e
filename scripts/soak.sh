#!/usr/bin/env bash
# Converts many photos in one process and a long video in another one. Prints their memory, open files and
# threads at intervals, and fails if one of these grows during the run (see judge below).
#
#   scripts/soak.sh [PHOTOS [SECONDS [PLAYED]]]      1000 photos, an hour of video, 600 s played
#
# Then the viewer's tests run; with $ALTIRO3D_CLICK_SECONDS, one of them plays a video with a white picture and a click
# in each second for PLAYED seconds, and they fail if a picture is shown more than 40 ms from its click in the recording
# of what was played.
#
# The photos are docs/examples/sample.jpg at sixteen sizes, the video is made of FFmpeg's test
# pictures with sound; $SOAK_CLIP is used instead if it is set, again and again, and $SOAK_NETWORK is
# the depth network of both. The panel is 384 x 512 px.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 3 -- "$@"
cd "$(dirname "$0")/.."
photos=${1:-1000} seconds=${2:-3600} played=${3:-600}
for number in "$photos" "$seconds" "$played"; do check_number "$number" "a number of photos or seconds"; done
tools=build/dev/tools
network=(${SOAK_NETWORK:+-n "$SOAK_NETWORK"})
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
export XDG_CACHE_HOME=$place/cache
sed -e 's/1536\.0/384.0/; s/2048\.0/512.0/; s/324\.0/81.0/' \
    calibration/portrait-sample.json >"$place/panel.json"

# sample PID: memory in KB, open files, threads; nothing once the process has ended.
sample() {
    local memory threads files
    memory=$(awk '/^VmRSS/ { print $2 }' "/proc/$1/status" 2>/dev/null) || return 0
    threads=$(awk '/^Threads/ { print $2 }' "/proc/$1/status" 2>/dev/null) || return 0
    files=$(find "/proc/$1/fd" -type l 2>/dev/null | wc -l) || return 0
    [[ -z $memory || -z $threads ]] || echo "$memory $files $threads"
}

# watch PID ROWS-APART MOST-SECONDS UNIT COUNT: rows until the process ends; stops it in time. Each
# second's sample goes to $place/samples.
watch() {
    local pid=$1 apart=$2 most=$3 unit=$4 count=$5 begin=$SECONDS next=0 held now
    printf '| wall clock, s | %s | memory, MB | open files | threads |\n|---:|---:|---:|---:|---:|\n' \
        "$unit"
    : >"$place/samples"
    while kill -0 "$pid" 2>/dev/null; do
        held=$((SECONDS - begin))
        now=$(sample "$pid")
        if [[ -n $now ]]; then
            echo "$now" >>"$place/samples"
            if ((held >= next)); then
                awk -v s="$held" -v n="$($count)" \
                    '{ printf "| %d | %s | %.1f | %d | %d |\n", s, n, $1 / 1024, $2, $3 }' <<<"$now"
                next=$((held + apart))
            fi
        fi
        if ((most > 0 && held >= most)); then
            kill -INT "$pid" 2>/dev/null || true
            most=0
        fi
        sleep 1
    done
}

# judge WHAT: compares the medians of the last and the second quarter of the samples. Fails for over 10 %
# more memory, or over two more open files or threads (a photo that is being read is one open file).
# Medians are used because single samples depend on the current photo, and the last ones on the joining
# of segments. The first quarter is not used, because the C library's free memory still grows in it.
judge() {
    python3 - "$1" "$place/samples" <<'PYTHON'
import statistics, sys
what, path = sys.argv[1:]
samples = [[int(number) for number in line.split()] for line in open(path)]
quarter = len(samples) // 4
if quarter < 2:
    sys.exit(print(f"soak: {what}: too short to tell whether anything grows"))
grown = []
for column, name in enumerate(("memory, KB", "open files", "threads")):
    held = [sample[column] for sample in samples]
    before, after = (statistics.median(part) for part in (held[quarter:2 * quarter], held[-quarter:]))
    if after > (before * 1.1 if column == 0 else before + 2):
        grown.append(f"{name}: {before:g} before half time, {after:g} at the end")
if grown:
    sys.exit(f"soak: {what}: FAILED, holds more and more: " + "; ".join(grown))
PYTHON
}

failed=0
if ((photos > 0)); then
    mkdir "$place/photos" "$place/natives"
    for ((i = 0; i < 16; ++i)); do
        ffmpeg -v error -i docs/examples/sample.jpg \
            -vf "scale=$((320 + 40 * i)):-2,hue=h=$((20 * i))" -q:v 3 "$place/size-$i.jpg"
    done
    for ((i = 0; i < photos; ++i)); do
        ln "$place/size-$((i % 16)).jpg" "$place/photos/$(printf '%05d' "$i").jpg"
    done
    made() { ls "$place/natives" | wc -l; }
    "$tools/photo2native" -c "$place/panel.json" "${network[@]}" "$place/photos" "$place/natives" \
        >"$place/log" 2>&1 &
    process=$!
    watch "$process" "${SOAK_APART:-20}" 0 photos made
    wait "$process" || { tail -3 "$place/log" >&2; exit 1; }
    echo "$(made) photos were made"
    judge photos || failed=1
    rm -rf "$place/photos" "$place/natives"
fi

if ((seconds > 0)); then
    if [[ -n ${SOAK_CLIP:-} ]]; then
        clip=(-stream_loop -1 -i "$SOAK_CLIP")
    else
        ffmpeg -v error -f lavfi -i testsrc2=size=480x270:rate=25 -f lavfi -i sine=frequency=440 \
            -t 60 -pix_fmt yuv420p -c:v libx264 -preset fast -c:a aac "$place/minute.mp4"
        clip=(-stream_loop -1 -i "$place/minute.mp4")
    fi
    # no faster than 200 pictures a second, 25 of which are a second of video
    ffmpeg -v error "${clip[@]}" -t $((seconds * 8)) -c copy "$place/long.mkv"
    made() {
        local segments
        segments=$(grep -c '"state"' "$place/native.mp4.parts/run.json" 2>/dev/null || true)
        echo "${segments:-0}"
    }
    "$tools/video2native" -c "$place/panel.json" "${network[@]}" "$place/long.mkv" \
        "$place/native.mp4" >"$place/log" 2>&1 &
    process=$!
    watch "$process" "${SOAK_APART:-240}" "$seconds" "segments of 6 s" made
    wait "$process" || [[ $? == 130 ]] || { tail -3 "$place/log" >&2; exit 1; }
    tail -1 "$place/log"
    ffprobe -v error -count_packets -show_entries stream=codec_name,nb_read_packets \
        -of csv=p=0 "$place/native.mp4"
    judge video || failed=1
fi

if ((played > 0)); then
    ALTIRO3D_CLICK_SECONDS=$played ALTIRO3D_LONGEST_TEST=1000 build/dev/tests/qt/altiro3D_qt_tests >"$place/log" 2>&1 ||
        failed=1
    grep -E 'Failure|Skipped' -A3 "$place/log" || true
    grep 'after their clicks' "$place/log" || failed=1
fi
exit "$failed"
