#!/usr/bin/env bash
# Tries the programs for Windows under Wine: the tools write the bytes of the Linux build of the same commit,
# names of all kinds work, a stopped video goes on, the window opens, the installer leaves nothing behind.
#
#   scripts/check-windows.sh [BUILD]
#
# BUILD is a build for Linux of the same commit, as build/dev: then that is taken, and what is in build/windows/.
# Otherwise both are built first.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 -- "$@"
cd "$(dirname "$0")/.."
linux=${1:-build/package}
if [[ $# -eq 0 ]]; then
    scripts/build-windows.sh
    cmake --preset package
    cmake --build --preset package
fi
scripts/install-dependencies.sh windows
out=$PWD/build/windows
folder=$(echo "$out"/altiro3D-*-windows-x64/)
export ALTIRO3D_WINDOWS_LIBRARIES=$out/libraries PKG_CONFIG_LIBDIR=$out/libraries/lib/pkgconfig PKG_CONFIG_PATH=
export WINEPREFIX=$out/wine WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml='
# shellcheck source=scripts/log.sh
. scripts/log.sh
log_to "$out/log"
fail() {
    echo "$0: $1" >&2
    exit 1
}

# 1. Only DLLs of Windows and ours are asked for
system='^(ADVAPI32|AVICAP32|bcrypt|comdlg32|CRYPT32|D3D11|D3D9|dnsapi|dwmapi|DWrite|DXGI|GDI32|IMM32|IPHLPAPI|KERNEL32|MPR|msvcrt|netapi32|OLEAUT32|ole32|PSAPI|Secur32|SETUPAPI|SHELL32|SHLWAPI|USER32|userenv|USP10|UxTheme|VERSION|WINMM|WINSPOOL|ws2_32|WTSAPI32|api-ms-win-.*)\.(dll|DRV)$'
find "$folder/bin" -name '*.[ed][xl][el]' -exec x86_64-w64-mingw32-objdump -p {} + | sed -n 's/.*DLL Name: //p' |
    sort -u | grep -viE "$system" | while read -r name; do
    [[ -e $folder/bin/$name ]] || fail "$name is needed, which is not of Windows"
done

# 2. The bytes of the tools
logged wineboot --init
wineserver --wait
mkdir -p "$out/by-wine/tools"
for program in "$folder"/bin/*.exe; do
    tool=$(basename "$program" .exe)
    printf '#!/bin/sh\nexec wine "%s" "$@"\n' "$program" >"$out/by-wine/tools/$tool"
    chmod +x "$out/by-wine/tools/$tool"
done
scripts/compare-results.sh "$linux" "$out/by-wine"

# 3. The unit tests, but for those that need POSIX. Those that run the programs ffmpeg and ffprobe skip themselves.
scripts/windows-libraries.sh gtest
logged cmake -G Ninja -S . -B "$out/tests" -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/windows.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DALTIRO3D_BUILD_{TOOLS,QT,BENCHMARKS,PYTHON}=OFF -DALTIRO3D_WITH_ONNXRUNTIME=OFF -DCMAKE_CROSSCOMPILING_EMULATOR=wine
logged cmake --build "$out/tests" --target altiro3D_unit_tests
ctest --test-dir "$out/tests" -L unit -j "$(nproc)" --output-on-failure

# 4. Names, standard streams, errors
work=$(mktemp -d)
server=
trap 'wineserver --kill || true; [[ -z $server ]] || kill "$server" || true; rm -rf "$work"' EXIT
cp docs/examples/sample.jpg docs/examples/sample-depth.png "$work/"
cp calibration/portrait-sample.json "$work/visual.json"
cd "$work"
tool() { "$out/by-wine/tools/$1" "${@:2}"; }
display=(-c visual.json)
tool photo2native "${display[@]}" -d sample.jpg sample-depth.png native.png
long=$(printf 'x%.0s' {1..200})
mkdir -p "$long/$long"
for name in ü日.png '🙂.png' "$long/$long/native.png"; do
    cp sample.jpg "$(dirname "$name")/photo-$(basename "$name" .png).jpg"
    tool photo2native "${display[@]}" -d "$(dirname "$name")/photo-$(basename "$name" .png).jpg" sample-depth.png "$name"
    cmp native.png "$name"
done
tool photo2native "${display[@]}" -d - sample-depth.png - <sample.jpg >stream.png
cmp native.png stream.png
said=$(tool photo2native "${display[@]}" -d sample.jpg sample-depth.png CON.png 2>&1) && fail "CON.png was accepted"
grep -q 'Windows keeps for a device' <<<"$said"
said=$(tool photo2native "${display[@]}" nowhere.jpg o.png 2>&1 >/dev/null) && fail "a missing photo was accepted"
[[ $(wc -l <<<"$said") == 1 ]] || fail "an error has several lines: $said"

# 5. Two runs with one output; a run that is ended by TerminateProcess, as by the task manager, and resumed
tool photo2native "${display[@]}" --seconds 8 --size 640x360 --lg clip.mp4 -d sample.jpg sample-depth.png other.png
run=(tool video2native "${display[@]}" -y -q 3x4 -r 280x210)
"${run[@]}" clip.mp4 whole.mkv
"${run[@]}" clip.mp4 part.mkv &
while [[ ! -e part.mkv.parts/000002.mp4.part ]]; do sleep 0.2; done
said=$("${run[@]}" clip.mp4 part.mkv 2>&1) && fail "two runs write one file"
grep -q 'in use by another process' <<<"$said"
pkill -KILL -f 'video2native.exe'
wait || true
"${run[@]}" --resume clip.mp4 part.mkv
cmp whole.mkv part.mkv
[[ ! -e part.mkv.parts ]] || fail "part.mkv.parts was left"

# 6. A full disk, where a small one can be made
mkdir full
if mount -t tmpfs -o size=64k tmpfs full 2>/dev/null; then
    said=$(tool photo2native "${display[@]}" -d sample.jpg sample-depth.png full/native.png 2>&1 >/dev/null) &&
        fail "a full disk was not seen"
    left=$(ls -A full)
    umount full
    [[ $(wc -l <<<"$said") == 1 && -z $left ]] || fail "on a full disk: $said; left: $left"
fi

# 7. The window, on a screen as the display's: it exports what the tool makes, also after a change that is
# undone, and a show has the Native's pixels
wineserver --wait
rm -rf "$WINEPREFIX"/drive_c/users/*/AppData/Local/altiro3D # what it remembers of photos
exec 9< <(exec Xvfb -displayfd 1 -screen 0 1536x2048x24 -nolisten tcp 2>>"$log")
server=$!
read -r -u 9 number
export DISPLAY=:$number
pixels() { ffmpeg -v error "$@" -frames:v 1 -pix_fmt rgb24 -f rawvideo - </dev/null | md5sum; }
export_as() { # file
    xdotool key ctrl+s
    sleep 4
    xdotool key End shift+Home
    xdotool type "Z:${work//\//\\}\\$1"
    xdotool key Return
    for _ in {1..60}; do [[ -e $1 ]] && sleep 1 && return; sleep 1; done
    fail "the window does not export $1"
}
tool altiro3Dview "${display[@]}" -d sample.jpg sample-depth.png &
viewer=$!
sleep 15
xdotool mousemove 400 400
export_as window.png
cmp native.png window.png
xdotool click 4 # the wheel: a closer frame
export_as closer.png
! cmp -s native.png closer.png || fail "the wheel does not change the picture"
xdotool key ctrl+z
export_as undone.png
cmp native.png undone.png
xdotool key ctrl+q
wait $viewer || fail "the window ends with an error"
tool altiro3Dview "${display[@]}" --show native.png --screen 0 &
viewer=$!
sleep 15
[[ $(pixels -f x11grab -draw_mouse 0 -video_size 1536x2048 -i "$DISPLAY") == "$(pixels -i native.png)" ]] ||
    fail "the show has other pixels than the Native"
xdotool key Escape
wait $viewer || fail "the show ends with an error"

# 8. The installer
wine "${folder%/}-setup.exe" /S
installed=$(find "$WINEPREFIX/drive_c/users" -path '*/Programs/altiro3D' -prune)
wine "$installed/bin/photo2native.exe" "${display[@]}" -d sample.jpg sample-depth.png installed.png
cmp native.png installed.png
wine "$installed/uninstall.exe" /S
for _ in {1..30}; do [[ ! -e $installed ]] || sleep 1; done # it goes on by itself
[[ ! -e $installed ]] || fail "the uninstaller leaves $installed"
wineserver --wait
! grep -i 'OpenWithList.*altiro3D' "$WINEPREFIX/user.reg" || fail "the uninstaller leaves entries in the registry"
echo "the programs for Windows are good, as far as Wine shows"
