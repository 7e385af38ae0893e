#!/usr/bin/env bash
# Tests scripts/get-models.sh without a network: downloads come from file:// through the variable
# that exists for this. Usage: get_models_test.sh PATH-OF-get-models.sh
set -uo pipefail

script=${1:-$(dirname -- "$0")/../../scripts/get-models.sh}
root=$(mktemp -d)
trap 'rm -rf -- "$root"' EXIT
failures=0

# Runs the script; leaves its status in `status` and all it says in `output`.
run() {
    output=$("$script" "$@" 2>&1)
    status=$?
}

expect() { # description, condition...
    local what=$1
    shift
    if ! "$@"; then
        failures=$((failures + 1))
        printf 'FAILED: %s (status %s)\n%s\n' "$what" "$status" "$output"
    fi
}

says() { [[ $output == *"$1"* ]]; }
ends() { [[ $status == "$1" ]]; }
is_empty() { [[ ! -e $1 || -z $(ls -A -- "$1") ]]; }
same() { cmp -s -- "$1" "$2"; }

mkdir -p "$root/server" "$root/with blank"
printf 'the small network' >"$root/server/small.onnx"
printf 'the large network' >"$root/server/large.onnx"
small_hash=$(sha256sum <"$root/server/small.onnx" | cut -d ' ' -f 1)
cat >"$root/catalog.json" <<JSON
{"networks": [
  {"name": "small", "file": "small.onnx", "url": "https://localhost/small.onnx", "bytes": 17,
   "sha256": "$small_hash"},
  {"name": "short", "file": "short.onnx", "url": "https://localhost/short.onnx", "bytes": 5,
   "sha256": "$small_hash"},
  {"name": "large", "file": "large.onnx", "url": "https://localhost/large.onnx", "bytes": 0,
   "sha256": ""},
  {"name": "unresolved", "file": "unresolved.onnx", "url": "https://nowhere.invalid/unresolved.onnx",
   "bytes": 2000001, "sha256": "$small_hash"},
  {"name": "refused", "file": "refused.onnx", "url": "https://localhost/refused.onnx",
   "bytes": 2000001, "sha256": "$small_hash"},
  {"name": "nowhere", "file": "nowhere.onnx", "url": "", "bytes": 0, "sha256": ""}
]}
JSON
export ALTIRO3D_CATALOG=$root/catalog.json
export ALTIRO3D_MODEL_BASE_URL=file://$root/server
target="$root/with blank/models"

run --help
expect "--help succeeds" ends 0
expect "--help shows the usage" says "Usage: get-models.sh"
run --wrong
expect "an unknown option is wrong usage" ends 2
run small large
expect "two names are wrong usage" ends 2
run --dir
expect "--dir without a value is wrong usage" ends 2
run --list --dir "$target"
expect "--list succeeds" ends 0
expect "--list shows size and place" says "small: small.onnx, 17 bytes, not in $target"
expect "--list tells what has no download" says "nowhere: nowhere.onnx, size unknown, not in $target, no download known"
run unknown --dir "$target"
expect "an unknown network fails" ends 1
expect "an unknown network is named with the known ones" says "unknown is not in the catalogue, expected one of: small short large unresolved refused nowhere"
run nowhere --dir "$target"
expect "a network without a URL fails" ends 1
expect "a network without a URL is explained" says "put nowhere.onnx into $target by hand"

run small --dir "$target"
expect "a good download succeeds" ends 0
expect "a good download is the file" same "$root/server/small.onnx" "$target/small.onnx"
expect "a good download may be read by all" [ "$(stat -c %a "$target/small.onnx")" = 644 ]
expect "a good download leaves nothing else" [ "$(ls -A "$target")" = small.onnx ]
run small --dir "$target"
expect "a second run keeps the good file" says "is there and good"
expect "a second run succeeds" ends 0

printf 'damaged by a disk' >"$target/small.onnx"
run small --dir "$target"
expect "a damaged file is not overwritten" ends 1
expect "a damaged file is explained" says "has the SHA-256"
expect "a damaged file stays" [ "$(cat "$target/small.onnx")" = "damaged by a disk" ]
rm -r "$target"

printf 'another networkkk' >"$root/server/small.onnx"
run small --dir "$target"
expect "a wrong hash fails" ends 1
expect "a wrong hash is explained" says "expected $small_hash (the catalogue); nothing was kept"
expect "a wrong hash keeps nothing" is_empty "$target"
printf '<html>sorry</html>' >"$root/server/small.onnx"
run small --dir "$target"
expect "a wrong size fails" ends 1
expect "a wrong size keeps nothing" is_empty "$target"
printf 'x' >"$root/server/short.onnx"
run short --dir "$target"
expect "a short file is explained" says "has 1 bytes, expected 5"
rm "$root/server/small.onnx"
run small --dir "$target"
expect "a failed download fails" ends 1
expect "a failed download keeps nothing" is_empty "$target"

run large --dir "$target"
expect "an unknown hash is pinned" ends 0
expect "a pin is announced" says "pinned what came"
expect "a pin is noted" grep -q "^[0-9a-f]\{64\}  large.onnx$" "$target/pinned.sha256"
run large --dir "$target"
expect "a pinned file is good" says "is there and good"
rm "$target/large.onnx"
printf 'a changed network' >"$root/server/large.onnx"
run large --dir "$target"
expect "a file that differs from its pin fails" ends 1
expect "a file that differs from its pin is explained" says "($target/pinned.sha256); nothing was kept"
expect "a file that differs from its pin is not kept" [ ! -e "$target/large.onnx" ]

run --dir "$root/catalog.json/below" small
expect "a directory that cannot be made fails" ends 1

XDG_DATA_HOME="$root/data" run large
expect "the default folder is the data home" [ -f "$root/data/altiro3D/models/large.onnx" ]
output=$(env -u XDG_DATA_HOME -u HOME "$script" large 2>&1)
status=$?
expect "without HOME --dir is asked for" says "say where to put the file with --dir"

unset ALTIRO3D_MODEL_BASE_URL http_proxy https_proxy all_proxy HTTP_PROXY HTTPS_PROXY ALL_PROXY
for network in unresolved refused; do # no such name; nothing listens there
    run "$network" --dir "$target"
    expect "$network: fails" ends 1
    expect "$network: keeps nothing" [ -z "$(find "$target" -name ".*$network*")" ]
    expect "$network: size is told" says "Downloading $network.onnx, 2 MB, from https://"
    expect "$network: by hand: the file" says "as $target/$network.onnx"
    expect "$network: by hand: the checksum" says "SHA-256 $small_hash"
    expect "$network: by hand: then" says "get-models.sh $network --dir "
done
run unresolved --dir "$target"
expect "the reason is told: no such name" says "https://nowhere.invalid/unresolved.onnx: cannot be downloaded: the server's name was not found, expected a network connection"
expect "by hand: the URL" says "https://nowhere.invalid/unresolved.onnx with a browser"
run refused --dir "$target"
expect "the reason is told: no connection" says "https://localhost/refused.onnx: cannot be downloaded: no connection to the server"

# shellcheck disable=SC2016 # the text must reach the catalogue as it is
printf '%s' '{"networks": [{"name": "a", "file": "a;$(touch x)", "url": "https://localhost/a"}]}' \
    >"$root/catalog.json"
run a --dir "$target"
expect "a catalogue with odd names is refused" ends 1
for outside in ../a /a .. .a; do
    printf '{"networks": [{"name": "a", "file": "%s", "url": "https://localhost/a"}]}' "$outside" \
        >"$root/catalog.json"
    run a --dir "$target"
    expect "the file $outside, outside of the folder or hidden, is refused" ends 1
    expect "the file $outside is explained" says "'$outside' is not as expected"
done
printf '%s' '{"networks": [{"name": "a", "file": "a", "url": "http://localhost/a"}]}' \
    >"$root/catalog.json"
run a --dir "$target"
expect "a URL that is not https is refused" ends 1
expect "a URL that is not https is explained" says "cannot be used as a catalogue"
printf '%s' '{"networks": [' >"$root/catalog.json"
run a --dir "$target"
expect "a damaged catalogue fails in one line" [ "$(wc -l <<<"$output")" = 1 ]
expect "a damaged catalogue is explained" says "cannot be used as a catalogue"

if ((failures > 0)); then
    echo "$failures failed"
    exit 1
fi
echo "all passed"
