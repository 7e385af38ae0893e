#!/usr/bin/env bash
# Runs the tools under faults: bad inputs, outputs that cannot be written, too little memory, killed
# processes. In all cases a tool must end with 0, 1 or 2, print one line if it fails, and leave each
# output complete, either the old one or the new one.
#
#   faults_test.sh DIRECTORY-OF-TOOLS SOURCE-TREE [KILLS [TOOL|inputs]]
#
# With TOOL only that tool is tested, with "inputs" only malicious inputs; otherwise everything.
set -uo pipefail
tools=$1
source=$2
kills=${3:-20}
part=${4:-all}
root=$(mktemp -d "${TMPDIR:-/tmp}/altiro3D-faults-XXXXXX")
# a full disk that an interrupted run left mounted would keep the directory
trap 'cd /; umount "$root/full" 2>/dev/null; chmod -R u+rwx "$root"; rm -rf -- "$root"' EXIT
chmod 755 "$root" # nobody must get in
export XDG_CACHE_HOME=$root/cache HOME=$root/home LANG=C.UTF-8 ALTIRO3D_MODELS=$source/models
unset LKG_CALIBRATION XDG_DATA_HOME
mkdir -p "$root/home" "$root/in"
failures=0
checks=0
tools_tried=(altiro3Dnative altiro3Dtradeoff native2view photo2native quilt2native quilt2video
             slide2native splat2native video2native views2native)
case $part in
all) ;;
altiro3Dview | inputs) tools_tried=() ;;
*) tools_tried=("$part") ;;
esac

fail() {
    failures=$((failures + 1))
    printf 'FAILED: %s\n  exit status %s, standard error: %s\n' "$1" "$status" \
        "$(head -c 600 "$root/err")"
}
check() { # description, condition...
    local what=$1
    shift
    checks=$((checks + 1))
    "$@" || fail "$what"
}
skip() { printf 'skipped: %s\n' "$1"; }

# Runs a tool; leaves its status in `status`, what it says in $root/out and $root/err.
run() {
    local tool=$1
    shift
    timeout 120 "$tools/$tool" "$@" >"$root/out" 2>"$root/err" </dev/null
    status=$?
}
ends() { [[ $status == "$1" ]]; }
ends_by_itself() { [[ $status -le 2 ]]; }
one_error() { # of a tool, with a part
    [[ $(wc -l <"$root/err") -eq 1 && $(<"$root/err") == "$1: error: "*"$2"* ]]
}
done_or_one_error() { [[ $status -eq 0 ]] || { ends_by_itself && one_error "$1" ""; }; }
holds_no_leftovers() { [[ -z $(find "$1" -name '.altiro3D-*' -o -name '*.part') ]]; }
same() {
    if [[ $1 == *.csv ]]; then
        same_table "$@"
    else
        cmp -s -- "$1" "$2"
    fi
}
same_table() { # of altiro3Dtradeoff, without the name of the photo, times and memory
    python3 - "$@" 2>/dev/null <<'PYTHON'
import csv, sys
tables = [[(row[1], row[4:8]) for row in csv.reader(open(path, newline=""))] for path in sys.argv[1:]]
sys.exit(tables[0] != tables[1])
PYTHON
}

# Runs a tool in little address space: megabytes, tool, arguments... Fails where not even --version
# comes out, as others' libraries cannot be loaded.
run_within() {
    local limit=$(($1 * 1024)) tool=$2
    shift 2
    { (ulimit -v "$limit" && exec "$tools/$tool" --version); } >/dev/null 2>&1 </dev/null || return
    (ulimit -v "$limit" && exec timeout 60 "$tools/$tool" "$@") >"$root/out" 2>"$root/err"
    status=$?
    sed -i '/^x264 \[error\]: malloc/d' "$root/err" # which x264 says for itself
}
limits=(270 285 300 320 335 350 400 500 600 700 800 1000 1300) # MB; libraries alone take some 260 to 310

# The arguments of a run that succeeds, in `words`: of a tool, its input and its output.
call() {
    local display=(-c "$root/in/small.json" -q 2x3 -r 40x30)
    case $1 in
    altiro3Dnative) words=(-m "$3" -q 2x3 -r 40x30 -- "$2") ;;
    altiro3Dtradeoff) # against a true view: in the pictures' own size, which is quick
        words=(--csv "$3" -j 1 --photo="$2" --disparity "$root/in/views/view_1.png"
               --disparity-scale 50 --truth "$root/in/views/view_2.png")
        ;;
    native2view | photo2native | quilt2native | slide2native | splat2native | views2native) words=("${display[@]}" -- "$2" "$3") ;;
    quilt2video) words=(-q 2x3 --seconds 0.2 --turns 1 --fps 20 -j 1 -- "$2" "$3") ;;
    video2native) words=("${display[@]}" -j 1 -- "$2" "$3") ;;
    esac
}
input_of() {
    case $1 in
    altiro3Dnative) echo "$root/in/small.json" ;;
    altiro3Dtradeoff) echo "$root/in/views/view_0.png" ;;
    native2view) echo "$root/in/native.png" ;;
    photo2native) echo "$root/in/photo.jpg" ;;
    slide2native) echo "$root/in/slide" ;;
    splat2native) echo "$root/in/scan.ply" ;;
    video2native) echo "$root/in/clip.mp4" ;;
    views2native) echo "$root/in/views" ;;
    *) echo "$root/in/quilt_qs3x2a0.75.png" ;;
    esac
}
ending_of() {
    case $1 in
    altiro3Dnative) echo map ;;
    altiro3Dtradeoff) echo csv ;;
    quilt2video) echo mp4 ;;
    video2native) echo mkv ;;
    *) echo png ;;
    esac
}

cat >"$root/in/small.json" <<JSON
{"configVersion": "1.0", "serial": "TEST", "pitch": {"value": 52.58}, "slope": {"value": -7.17},
 "center": {"value": 0.5}, "viewCone": {"value": 40}, "invView": {"value": 1}, "DPI": {"value": 324},
 "screenW": {"value": 96}, "screenH": {"value": 128}}
JSON
cp "$source/docs/examples/sample.jpg" "$root/in/photo.jpg"
cd "$root" || exit 1
run photo2native -c in/small.json -q 2x3 -r 40x30 --save-quilt in/quilt.png --save-views in/views \
    in/photo.jpg in/native.png
check "inputs can be made" ends 0
run photo2native --save-splats in/scan.ply --splat-side 64 in/photo.jpg
check "splats can be made" ends 0
run photo2native -c in/small.json -q 4x3 -r 360x480 --save-views in/slide in/photo.jpg in/slide.png
check "a slide can be made" ends 0
run quilt2video -q 2x3 --seconds 0.2 --turns 1 --fps 20 in/quilt_qs3x2a0.75.png in/clip.mp4
check "a video can be made" ends 0
[[ $failures -eq 0 ]] || exit 1

# A decimal comma: few machines have this locale, so it is made.
localedef -i de_DE -f UTF-8 "$root/de_DE.UTF-8" 2>/dev/null ||
    skip "a decimal comma (needs Debian's package locales)"

# The tools are asked whether they are built with a sanitizer: its memory is not a tool's.
sanitized=$(ldd "$tools/photo2native" | grep -cE 'lib[at]san')

for tool in "${tools_tried[@]}"; do
    ending=$(ending_of "$tool")
    input=$(input_of "$tool")
    out=$root/out.$ending
    suffix=${input##*/}
    [[ $suffix == *.* ]] && suffix=.${suffix##*.} || suffix=
    call "$tool" "$input" "$root/reference.$tool.$ending"
    run "$tool" "${words[@]}"
    check "$tool: works" ends 0
    reference=$root/reference.$tool.$ending

    # --- inputs
    mkdir -p bad/directory
    : >bad/empty
    head -c 300 /dev/urandom >bad/noise
    for kind in missing empty noise directory; do
        [[ $tool != views2native || $kind != directory ]] || continue
        call "$tool" "$root/bad/$kind" "$out"
        run "$tool" "${words[@]}"
        check "$tool: input is $kind" ends 1
        check "$tool: input is $kind: one line that names it" one_error "$tool" "bad/$kind: "
        check "$tool: input is $kind: no output" test ! -e "$out"
    done
    if [[ $(id -u) -eq 0 ]] && command -v setpriv >/dev/null; then
        as_nobody=(setpriv --reuid=65534 --regid=65534 --clear-groups env XDG_CACHE_HOME=/nonexistent)
        rm -rf secret shared
        mkdir secret shared
        cp -r "$input" "secret/input$suffix"
        chmod -R go-rwx secret/*
        chmod 777 shared
        if "${as_nobody[@]}" test -x "$tools/$tool"; then
            call "$tool" "$root/secret/input$suffix" "$root/shared/out.$ending"
            timeout 120 "${as_nobody[@]}" "$tools/$tool" "${words[@]}" >out 2>err
            status=$?
            check "$tool: input may not be read" ends 1
            check "$tool: input may not be read: one line" one_error "$tool" "secret/input"
            chmod 755 shared
            call "$tool" "$input" "$root/shared/out.$ending"
            timeout 120 "${as_nobody[@]}" "$tools/$tool" "${words[@]}" >out 2>err
            status=$?
            check "$tool: directory may not be written" ends 1
            check "$tool: directory may not be written: one line" one_error "$tool" "shared/out"
            check "$tool: directory may not be written: nothing is in it" test -z "$(ls -A shared)"
        else
            skip "$tool: what may not be read or written (nobody cannot get to the tools)"
        fi
    else
        skip "$tool: what may not be read or written (needs root and setpriv)"
    fi

    # --- outputs
    mkdir -p full
    if mount -t tmpfs -o size=256k none "$root/full" 2>/dev/null; then
        cat /dev/zero >full/filler 2>/dev/null
        call "$tool" "$input" "$root/full/out.$ending"
        run "$tool" "${words[@]}"
        check "$tool: full disk" ends 1
        check "$tool: full disk: one line" one_error "$tool" "full/"
        check "$tool: full disk: nothing is left" test "$(ls -A full)" = filler
        umount "$root/full"
    else
        skip "$tool: full disk (needs the right to mount)"
    fi

    # --- two at once: each ends by itself, and what is there is whole
    call "$tool" "$input" "$out"
    for round in 1 2 3; do
        timeout 120 "$tools/$tool" -y "${words[@]}" >/dev/null 2>err2 &
        other=$!
        run "$tool" -y "${words[@]}"
        check "$tool: two at once, $round" ends_by_itself
        wait "$other"
        status=$?
        check "$tool: two at once, $round: the other" ends_by_itself
        check "$tool: two at once, $round: the output is whole" same "$out" "$reference"
    done
    rm -rf "$out" "$out.parts"

    # --- surroundings; glibc keeps what it makes of LOCPATH
    (exec env -i PATH=/usr/bin:/bin LOCPATH="$root" LC_ALL=de_DE.UTF-8 ASAN_OPTIONS=detect_leaks=0 \
        ALTIRO3D_MODELS="$ALTIRO3D_MODELS" "$tools/$tool" "${words[@]}") >out 2>err
    status=$?
    check "$tool: no HOME" ends 0
    check "$tool: no HOME: the same output" same "$out" "$reference"
    rm -f "$out"
    { timeout 120 "$tools/$tool" -v "${words[@]}" 2>err || echo "$?" >status; } | true
    status=$(cat status 2>/dev/null || echo 0)
    rm -f status
    check "$tool: nobody reads what it says" test "$status" -le 2 -o "$status" -eq 141
    if [[ -e $out ]]; then
        check "$tool: nobody reads what it says: the output is whole" same "$out" "$reference"
    fi
    rm -rf "$out" "$out.parts"

    timeout 120 "$tools/$tool" -y "${words[@]}" >&- 2>err
    status=$?
    check "$tool: no standard output" done_or_one_error "$tool"
    if [[ -e $out ]]; then
        check "$tool: no standard output: the output is whole" same "$out" "$reference"
    fi
    # the next file that is opened gets the number of standard output or standard error
    timeout 120 "$tools/$tool" -y "${words[@]}" <&- >&- 2>&-
    status=$?
    check "$tool: no standard streams" ends_by_itself
    if [[ -e $out ]]; then
        check "$tool: no standard streams: the output is whole" same "$out" "$reference"
    fi
    rm -rf "$out" "$out.parts"

    # --- memory
    if [[ $sanitized -eq 0 ]]; then
        for megabytes in "${limits[@]}"; do
            run_within "$megabytes" "$tool" -y "${words[@]}" </dev/null || continue
            check "$tool: $megabytes MB of memory" done_or_one_error "$tool"
            if [[ $status -eq 0 ]]; then
                check "$tool: $megabytes MB: the output is whole" same "$out" "$reference"
            fi
        done
        rm -rf "$out" "$out.parts"
    fi

    # --- killed at any moment
    rm -rf dying
    mkdir dying
    target=$root/dying/out.$ending
    call "$tool" "$input" "$target"
    start=$(date +%s%N)
    run "$tool" -y "${words[@]}"
    length=$((($(date +%s%N) - start) / 1000000 + 1)) # ms
    between=0
    met=0 # kills that came before the end
    for ((i = 0; i < kills; ++i)); do
        old=$((i % 2))
        rm -f "$target"
        [[ $old -eq 0 ]] || echo precious >"$target"
        "$tools/$tool" -y "${words[@]}" >/dev/null 2>&1 </dev/null &
        process=$!
        sleep "$(printf '0.%03d' $((RANDOM % (length < 900 ? length : 900))))"
        kill -KILL "$process" 2>/dev/null
        wait "$process" 2>/dev/null
        [[ $? -ne 137 ]] || met=$((met + 1))
        if [[ -e $target ]]; then
            same "$target" "$reference" || { [[ $old -eq 1 && $(<"$target") == precious ]]; } ||
                between=$((between + 1))
        elif [[ $old -eq 1 ]]; then
            between=$((between + 1))
        fi
    done
    status=killed
    check "$tool: killed $kills times: old or new, never between ($between)" test "$between" -eq 0
    check "$tool: killed $kills times: $met of them before its end" test "$met" -gt 0
    run "$tool" -y "${words[@]}"
    check "$tool: works after all" ends 0
    check "$tool: works after all: the output" same "$target" "$reference"
    # A kill in the microseconds between the naming and the renaming leaves the new file's first name.
    leftovers=(dying/.altiro3D-*.tmp)
    [[ ${#leftovers[@]} -gt 1 ]] || rm -f "${leftovers[0]}"
    check "$tool: nothing piles up: $(ls -A dying | tr '\n' ' ')" test "$(ls -A dying | wc -l)" -le 1
    check "$tool: nothing is left anywhere" holds_no_leftovers "$root"
done

# --- the viewer, on an offscreen desktop
run_viewer() { # file for its standard input, arguments...
    local input=$1
    shift
    timeout 120 "$tools/altiro3Dview" "$@" >out 2>err <"$input"
    status=$?
}
stays() { # description, arguments...: it shows something until it is ended
    local what=$1
    shift
    timeout 3 "$tools/altiro3Dview" "$@" >out 2>err </dev/null
    status=$?
    check "altiro3Dview: $what: stays" ends 124
    check "altiro3Dview: $what: says nothing" test ! -s err
}
if [[ $part == altiro3Dview || ($part == all && -x $tools/altiro3Dview) ]]; then
    tool=altiro3Dview
    export QT_QPA_PLATFORM=offscreen # a screen of 800 x 600 px
    # under sanitizers: what Qt itself keeps until the end is no leak of ours
    export LSAN_OPTIONS=print_suppressions=0:suppressions=$source/tests/qt/qt_leaks.supp
    { printf 'P6\n800 600\n255\n' && head -c 1440000 /dev/zero; } >screen.ppm
    cat screen.ppm screen.ppm screen.ppm >pictures
    head -c 100000 screen.ppm >broken.ppm
    show=(--screen 0 --show)
    run "$tool" --list-displays
    check "$tool: works" ends 0
    run_viewer pictures "${show[@]}" -
    check "$tool: shows pictures until they end" ends 0

    mkdir -p bad/directory
    : >bad/empty
    head -c 300 /dev/urandom >bad/noise
    for kind in missing empty noise directory; do
        for option in --show -c -m; do
            run "$tool" $([[ $option != --show ]] || echo --screen 0) "$option" "bad/$kind"
            check "$tool: $option $kind" ends 1
            check "$tool: $option $kind: one line that names it" one_error "$tool" "bad/$kind: "
        done
    done
    for input in bad/empty bad/noise broken.ppm; do
        run_viewer "$input" "${show[@]}" -
        check "$tool: standard input is $input" ends 1
        check "$tool: standard input is $input: one line" one_error "$tool" "standard input: "
    done
    # the window says what is wrong with a file
    stays "a window of bad files" bad/missing bad/empty bad/noise bad/directory
    stays "a window of a bad depth image" -d in/photo.jpg bad/noise
    stays "a Native" "${show[@]}" screen.ppm
    if [[ $(id -u) -eq 0 ]] && command -v setpriv >/dev/null; then
        mkdir -p secret
        cp in/native.png secret/input.png
        chmod go-rwx secret/input.png
        if setpriv --reuid=65534 --regid=65534 --clear-groups test -x "$tools/$tool"; then
            timeout 120 setpriv --reuid=65534 --regid=65534 --clear-groups \
                env XDG_CACHE_HOME=/nonexistent "$tools/$tool" --screen 0 --show "$root/secret/input.png" >out 2>err
            status=$?
            check "$tool: input may not be read" ends 1
            check "$tool: input may not be read: one line" one_error "$tool" "secret/input"
        else
            skip "$tool: what may not be read (nobody cannot get to the tools)"
        fi
    else
        skip "$tool: what may not be read (needs root and setpriv)"
    fi

    for arguments in "--list-displays" "--screen 0 --show -"; do
        read -ra words <<<"$arguments"
        (exec env -i PATH=/usr/bin:/bin QT_QPA_PLATFORM=offscreen LOCPATH="$root" \
            LC_ALL=de_DE.UTF-8 ASAN_OPTIONS=detect_leaks=0 "$tools/$tool" "${words[@]}") \
            >out 2>err <pictures
        status=$?
        check "$tool $arguments: no HOME" ends 0
        if [[ $sanitized -eq 0 ]]; then
            for megabytes in "${limits[@]}"; do
                run_within "$megabytes" "$tool" "${words[@]}" <pictures || continue
                check "$tool $arguments: $megabytes MB of memory" done_or_one_error "$tool"
            done
        fi
    done
    # a picture of another size: the message shows that it was read
    for name in 'with blank' $'line\nbreak' $'\xc3\xa4\xe6\x97\xa5' -dash; do
        cp in/native.png "./$name.png"
        run "$tool" --screen 0 --show="$name.png"
        check "$tool: the name '$name'" one_error "$tool" "${name/$'\n'/ }.png: has 96 x 128 px"
    done
    for format in "" --json; do
        timeout 120 "$tools/$tool" --list-displays $format >&- 2>err
        status=$?
        check "$tool: no standard output" one_error "$tool" "standard output"
        timeout 120 "$tools/$tool" --list-displays $format >/dev/full 2>err
        status=$?
        check "$tool: /dev/full as standard output" one_error "$tool" "standard output"
    done
    timeout 120 "$tools/$tool" "${show[@]}" - <pictures >&- 2>err
    status=$?
    check "$tool: shows pictures without a standard output" ends 0
    timeout 120 "$tools/$tool" --list-displays <&- >&- 2>&-
    status=$?
    check "$tool: no standard streams" ends_by_itself
    { timeout 120 "$tools/$tool" --list-displays 2>err || echo "$?" >status; } | true
    status=$(cat status 2>/dev/null || echo 0)
    rm -f status
    check "$tool: nobody reads what it says" test "$status" -le 2 -o "$status" -eq 141
    check "$tool: nothing is left anywhere" holds_no_leftovers "$root"
fi

finish() {
    echo "$checks checks, $failures failed"
    [[ $failures -eq 0 ]]
    exit
}
[[ $part == all || $part == inputs ]] || finish

# --- bombs: refused in one line, before memory is taken
peak() { # of a command, MB; its status in `status`
    python3 - "$root" "$@" <<'PYTHON'
import os, resource, subprocess, sys
root, command = sys.argv[1], sys.argv[2:]
with open(root + "/out", "wb") as out, open(root + "/err", "wb") as err:
    status = subprocess.call(command, stdout=out, stderr=err, stdin=subprocess.DEVNULL, timeout=120)
print(status, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024)
PYTHON
}
bomb() { # description, tool, input
    call "$2" "$3" "$root/bombed.$(ending_of "$2")"
    read -r status megabytes < <(peak "$tools/$2" "${words[@]}")
    check "$1" ends 1
    check "$1: one line" one_error "$2" "${3##*/}"
    check "$1: $megabytes MB" test "$sanitized" -gt 0 -o "$megabytes" -lt 200
}
# 60000 x 60000 px of 8-bit RGB, without a checksum that anybody needs
printf '\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xea\x60\0\0\xea\x60\x08\x02\0\0\0\0\0\0\0\0\0\0\0IEND\xae\x42\x60\x82' \
    >huge.png
bomb "60000 x 60000 px" photo2native "$root/huge.png"
cp huge.png huge_qs3x2a0.75.png
bomb "a quilt of 60000 x 60000 px" quilt2native "$root/huge_qs3x2a0.75.png"
bomb "a quilt of 60000 x 60000 px for a video" quilt2video "$root/huge_qs3x2a0.75.png"
mkdir huge && cp huge.png huge/a.png
call views2native "$root/huge" "$root/bombed.png"
bomb "a view of 60000 x 60000 px" views2native "$root/huge"
head -c 100000 /dev/zero | tr '\0' '[' >deep.json
bomb "JSON 100000 deep" altiro3Dnative "$root/deep.json"
{
    printf 'ALTIRO3D\1\0\0\0\x80\0\0\0\xff\xff\xff\xff\xff\xff\xff\xff'
    head -c 200 /dev/zero
} >terabytes.map
read -r status megabytes < <(peak "$tools/quilt2native" -m "$root/terabytes.map" \
    "$root/in/quilt_qs3x2a0.75.png" "$root/bombed.png")
check "a map of terabytes" ends 1
check "a map of terabytes: one line" one_error quilt2native "terabytes.map"
check "a map of terabytes: $megabytes MB" test "$sanitized" -gt 0 -o "$megabytes" -lt 200

# --- names with terminal escape sequences
if script -qc true /dev/null >/dev/null 2>&1; then
    mkdir orders
    for order in $'\x1b]0;order\x07' $'\xc2\x9b31m'; do
        cp in/photo.jpg "orders/a${order}b.jpg"
    done
    said=$(script -qec "'$tools/photo2native' -c in/small.json -q 2x3 -r 40x30 -j 1 orders ordered" /dev/null </dev/null)
    check "names on a terminal: works" test "$(ls ordered | wc -l)" -eq 2
    check "names on a terminal: progress is seen" test -n "$(grep -F '[2/2]' <<<"$said")"
    check "names on a terminal: no orders" test -z "$(LC_ALL=C grep -e $'\x1b\\]' -e $'\xc2\x9b' <<<"$said")"
    rm -r orders ordered
else
    skip "names on a terminal (needs pseudo-terminals)"
fi

# --- a network that crashes OpenCV
python3 - "$root/crash.onnx" <<'PYTHON'
import sys
def varint(v):
    b = b""
    while v >= 128: b += bytes([v & 127 | 128]); v >>= 7
    return b + bytes([v])
def number(f, v): return varint(f * 8) + varint(v)
def part(f, c): return varint(f * 8 + 2) + varint(len(c)) + c
def shape(s): return part(1, number(1, 1) + part(2, b"".join(part(1, number(1, x)) for x in s)))
weights = b"".join(number(1, s) for s in (1, 3, 3000, 3000)) + number(2, 1) + part(8, b"w") + part(9, bytes(4))
node = part(1, b"x") + part(1, b"w") + part(2, b"y") + part(3, b"c") + part(4, b"Conv")
graph = part(1, node) + part(2, b"g") + part(5, weights)
graph += part(11, part(1, b"x") + part(2, shape((1, 3, 32, 32)))) + part(12, part(1, b"y") + part(2, shape((1, 1, 32, 32))))
open(sys.argv[1], "wb").write(number(1, 4) + part(7, graph) + part(8, number(2, 9)))
PYTHON
echo '{"name": "crash", "inputWidth": 32, "inputHeight": 32}' >crash.json
for tool in photo2native video2native; do
    call "$tool" "$(input_of "$tool")" "$root/crashed.$(ending_of "$tool")"
    run "$tool" -n crash.onnx --net-profile crash.json --engine opencv "${words[@]}"
    check "$tool: a network that crashes OpenCV" ends 1
    check "$tool: a network that crashes OpenCV: one line" one_error "$tool" "crash.onnx: crashes when"
done
finish
