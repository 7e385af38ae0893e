#!/usr/bin/env bash
# scripts/quickstart.sh with stand-ins for apt, cmake and the tools: what it says, and what it does when
# a step fails. usage: quickstart_test.sh SOURCE_DIRECTORY
# shellcheck disable=SC2016 # stand-ins expand their own variables
set -uo pipefail
source=$1
root=$(mktemp -d)
trap 'rm -rf -- "$root"' EXIT
failures=0
clone=$root/the\ clone
here=$root/here
mkdir -p "$clone/scripts" "$clone/build/package/tools" "$clone/docs/examples" "$root/bin" "$here"
cp "$source"/scripts/{quickstart,install-dependencies,log,usage}.sh "$clone/scripts/"
touch "$clone/docs/examples/sample.jpg" "$clone/docs/examples/sample-depth.png" "$here/photo.jpg" "$here/visual.json"
stand_in() { # file, its shell commands
    printf '#!/usr/bin/env bash\n%s\n' "$2" >"$1"
    chmod +x "$1"
}
stand_in "$root/bin/sudo" 'exec "$@"'
stand_in "$root/bin/dpkg-query" 'cat "$MISSING" 2>/dev/null || echo ii'
stand_in "$root/bin/apt-get" 'case $* in
    *--print-uris*) printf "%s\n" "'\''file:/a.deb'\'' a.deb 1500000 SHA256:0" "'\''file:/b.deb'\'' b.deb 9500000 SHA256:0" ;;
    *) seq -f "line %g of apt" 100; [[ $* != *install* || ! -e $APT_FAILS ]] ;;
    esac'
stand_in "$root/bin/cmake" 'seq -f "line %g of cmake" 100; echo "[0/2] Re-checking globbed directories..."; echo "[1/2] Re-checking"; echo "[30/120] Building"; [[ ! -e $CMAKE_FAILS ]]'
stand_in "$clone/build/package/tools/photo2native" 'echo "depth: network altiro3d (altiro3d-depth.onnx)"; echo "from $PWD: $*" >"$CALL"
    echo native >"${!#}"'
stand_in "$clone/scripts/get-models.sh" 'echo "get-models.sh $*"; [[ ! -e $NO_NETWORK ]]'
export PATH=$root/bin:$PATH MISSING=$root/missing APT_FAILS=$root/apt_fails CMAKE_FAILS=$root/cmake_fails \
    NO_NETWORK=$root/no_network CALL=$root/call
log=$clone/quickstart-output/log.txt

run() {
    rm -f "$clone/native.png" "$CALL"
    output=$(cd "$here" && "$clone/scripts/quickstart.sh" "$@" 2>&1)
    status=$?
}
expect() { # description, condition...
    local what=$1
    shift
    "$@" && return
    failures=$((failures + 1))
    printf 'FAILED: %s (status %s)\n%s\n' "$what" "$status" "$output"
}
says() { [[ $output == *"$1"* ]]; }
says_not() { [[ $output != *"$1"* ]]; }
ends() { [[ $status == "$1" ]]; }
called() { [[ $(<"$CALL") == *"$1"* ]]; }
not_called() { [[ ! -e $CALL ]]; }

run --help
expect "--help succeeds" ends 0
expect "--help shows the usage" says "Usage: scripts/quickstart.sh"
run --wrong
expect "an unknown option is wrong usage" ends 2
run photo.jpg visual.json more
expect "a third name is wrong usage" ends 2
run none.jpg
expect "a photo that does not exist fails" ends 1
expect "a photo that does not exist is named" says "none.jpg: does not exist, expected a photo"
run photo.jpg none.json
expect "a calibration that does not exist is named" says "none.json: does not exist, expected a calibration"
expect "nothing was begun" not_called

run
expect "all goes well" ends 0
expect "nothing to install is not told" says_not "Installing"
expect "the long output is kept away" says_not "line 1 of"
expect "how long it takes is that of this computer" says "about $(((30 + $(nproc) - 1) / $(nproc))) minutes on the $(nproc) processor cores"
expect "how far it is" says "  25 %, 0 min "
expect "the log has it" grep -q "line 100 of cmake" "$log"
expect "the log is named" says "$log"
expect "native.png is there" [ -s "$clone/native.png" ]
expect "the sample is used" called "-- $clone/quickstart-output/sample.jpg $clone/quickstart-output/native.png"
expect "its depth is estimated, not read" [ ! -e "$clone/quickstart-output/sample-depth.png" ]
expect "the tools look where the caller stands" called "from $here: "
expect "it ends in few lines" [ "$(sed '1,/^$/d' <<<"$output" | wc -l)" -le 6 ]
expect "what native.png is" says "picture for your display. On any other screen it looks like a blur."
line=$(grep -o 'export PATH=.*' <<<"$output")
expect "the PATH to copy" [ "$(eval "$line"; command -v photo2native)" = "$clone/build/package/tools/photo2native" ]
expect "the viewer and key 5" says "sample.jpg    and press key 5"
expect "a better depth" says "get-models.sh midas-small"

run photo.jpg visual.json
expect "photo and calibration" called "-c $here/visual.json --save-quilt"
expect "photo and calibration: the photo" called "-- $here/photo.jpg"

echo missing >"$MISSING"
run --with-midas
expect "with packages and network" ends 0
expect "the real size is told" says "Installing 2 packages, 11 MB to download: g++ cmake"
expect "what the next step needs is installed" says " python3 curl ca-certificates"
expect "apt is in the log" grep -q "line 100 of apt" "$log"
expect "the network is downloaded" says "get-models.sh midas-small"
touch "$NO_NETWORK"
run --with-midas
expect "without a network it goes on" ends 0
expect "without a network it says so" says "midas-small was not downloaded; the network of altiro3D is used"

touch "$APT_FAILS"
run
expect "apt fails" [ "$status" != 0 ]
expect "apt fails: the end of the log" says "    line 100 of apt"
expect "apt fails: only the end" says_not "line 70 of apt"
expect "apt fails: nothing is made" not_called
rm "$MISSING"
touch "$CMAKE_FAILS"
run
expect "cmake fails" ends 1
expect "cmake fails: the command" says "this command failed: cmake --preset package"
expect "cmake fails: the end of the log" says "The end of $log:"
expect "cmake fails: nothing is made" not_called

((failures == 0)) && echo "all passed"
