#!/usr/bin/env bash
# Downloads a depth network of models/catalog.json and checks it before it gets its name.
set -euo pipefail

usage() {
    cat <<'TEXT'
Usage: get-models.sh [NAME] [--dir DIR]
       get-models.sh --list [--dir DIR]

Downloads the depth network NAME (midas-small if none is given) over https, checks its size and
SHA-256 and puts it into DIR. A good file that is there already is left alone.

  --dir DIR   where to put it (default: $XDG_DATA_HOME/altiro3D/models, else
              ~/.local/share/altiro3D/models)
  --list      show the known networks and whether they are in DIR
  --help      show this text

If no SHA-256 of a network is published, the script stores the hash of the first download in
DIR/pinned.sha256. Later downloads must have the same hash.
TEXT
}

fail() { # sentence
    echo "get-models.sh: error: $1" >&2
    exit 1
}

wrong_usage() { # sentence
    echo "get-models.sh: error: $1 (see --help)" >&2
    exit 2
}

name=
list=no
directory=
directory_given=no
while (($# > 0)); do
    case $1 in
    -h | --help)
        usage
        exit 0
        ;;
    --list) list=yes ;;
    --dir)
        (($# > 1)) || wrong_usage "--dir needs a directory"
        directory=$2
        [[ -n $directory ]] || wrong_usage "--dir needs a directory"
        directory_given=yes
        shift
        ;;
    -*) wrong_usage "unknown option $1" ;;
    *)
        [[ -z $name ]] || wrong_usage "one network at a time, not $name and $1"
        [[ -n $1 ]] || wrong_usage "the name of the network is empty"
        name=$1
        ;;
    esac
    shift
done
[[ $list == no || -z $name ]] || wrong_usage "--list takes no name"
name=${name:-midas-small}

if [[ -z $directory ]]; then
    if [[ ${XDG_DATA_HOME:-} == /* ]]; then
        directory=$XDG_DATA_HOME/altiro3D/models
    elif [[ ${HOME:-} == /* ]]; then
        directory=$HOME/.local/share/altiro3D/models
    else
        fail "HOME is not set, say where to put the file with --dir"
    fi
fi
[[ $directory == -* ]] && directory=./$directory

# Beside the script in the source tree, or where an installed copy finds it.
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
catalog=${ALTIRO3D_CATALOG:-}
if [[ -z $catalog ]]; then
    for candidate in "$here/../models/catalog.json" "$here/models/catalog.json" \
        "$here/../share/altiro3D/models/catalog.json"; do
        if [[ -f $candidate ]]; then
            catalog=$candidate
            break
        fi
    done
fi
[[ -n $catalog && -f $catalog ]] || fail "models/catalog.json is not next to this script's folder"
command -v python3 >/dev/null || fail "python3 is missing, install it (apt install python3)"
command -v sha256sum >/dev/null || fail "sha256sum is missing, install it (apt install coreutils)"

# One line per network: name, file, bytes, SHA-256 and URL, "-" where unknown. Fields with other
# characters than names and URLs have are refused, so that nothing else can reach the shell.
read_catalog() {
    python3 - "$catalog" <<'PYTHON'
import json
import re
import sys

try:
    with open(sys.argv[1], encoding="utf-8") as stream:
        networks = json.load(stream)["networks"]
    for network in networks:
        fields = [network["name"], network["file"], str(network.get("bytes") or "-"),
                  network.get("sha256") or "-", network.get("url") or "-"]
        patterns = [r"[A-Za-z0-9_][A-Za-z0-9._-]*", r"[A-Za-z0-9_][A-Za-z0-9._-]*", r"-|[0-9]+",
                    r"-|[0-9a-f]{64}", r"-|https://[A-Za-z0-9._~/%+-]+"]
        for field, pattern in zip(fields, patterns):
            if not re.fullmatch(pattern, field):
                raise ValueError(f"{field!r} is not as expected")
        print(*fields)
except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
    sys.exit(f"get-models.sh: error: {sys.argv[1]}: cannot be used as a catalogue ({error})")
PYTHON
}

networks=$(read_catalog) || exit 1

if [[ $list == yes ]]; then
    while read -r entry file bytes sha256 url; do
        state="not in $directory"
        [[ -f $directory/$file ]] && state="in $directory"
        [[ $url == - ]] && state+=", no download known"
        size="size unknown"
        [[ $bytes != - ]] && size="$bytes bytes"
        echo "$entry: $file, $size, $state"
    done <<<"$networks"
    exit 0
fi

found=no
known=
while read -r entry file bytes sha256 url; do
    known+=" $entry"
    if [[ $entry == "$name" ]]; then
        found=yes
        break
    fi
done <<<"$networks"
[[ $found == yes ]] || fail "$name is not in the catalogue, expected one of:$known"

target=$directory/$file
pins=$directory/pinned.sha256

hash_of() { # file
    sha256sum <"$1" | cut -d ' ' -f 1
}

# The hash this file must have: the catalogue's, else the one pinned earlier, else nothing.
wanted=$sha256
source="the catalogue"
if [[ $wanted == - && -f $pins ]]; then
    wanted=$(awk -v file="$file" '$2 == file { hash = $1 } END { print hash }' "$pins")
    source=$pins
fi
[[ $wanted == - ]] && wanted=

# Sets `problem` to what is wrong with a file, or to nothing.
check() { # file
    problem=
    local size
    size=$(stat -c %s -- "$1")
    if [[ $bytes != - && $size != "$bytes" ]]; then
        problem="has $size bytes, expected $bytes"
        return
    fi
    actual=$(hash_of "$1")
    if [[ -n $wanted && $actual != "$wanted" ]]; then
        problem="has the SHA-256 $actual, expected $wanted ($source)"
    fi
}

part=''   # what is being written
pinned=''
trap 'rm -f -- ${part:+"$part"} ${pinned:+"$pinned"}' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

pin() { # notes the hash of a file that has none yet
    pinned=$(mktemp -- "$directory/.pinned.XXXXXX")
    if [[ -f $pins ]]; then cat -- "$pins" >"$pinned"; fi
    echo "$actual  $file" >>"$pinned"
    chmod 644 -- "$pinned"
    mv -f -- "$pinned" "$pins"
    echo "Nobody publishes a SHA-256 of $file; pinned what came:"
    echo "  $actual (noted in $pins)"
}

if [[ -e $target ]]; then
    [[ -f $target ]] || fail "$target is there and is no file, move it away first"
    check "$target"
    [[ -z $problem ]] || fail "$target is there and $problem; move it away to download it again"
    [[ -n $wanted ]] || pin
    echo "$target is there and good."
    exit 0
fi

[[ $url != - ]] || fail "no download is known for $name; put $file into $directory by hand"

# For tests only: the place of the last part of the URL, which may be file://.
protocol=https
if [[ -n ${ALTIRO3D_MODEL_BASE_URL:-} ]]; then
    url=${ALTIRO3D_MODEL_BASE_URL%/}/$file
    protocol=https,file
fi

mkdir -p -- "$directory" || fail "cannot make $directory"
# GNU mktemp makes it readable to its owner alone; it stays hidden until it is checked.
part=$(mktemp -- "$directory/.$file.XXXXXX" 2>/dev/null) || fail "cannot write into $directory"
size="size unknown"
[[ $bytes == - ]] || size="$(((bytes + 500000) / 1000000)) MB"
echo "Downloading $file, $size, from $url"

cannot_download() { # why
    local again
    again=$(printf '%q %q' "$0" "$name")
    [[ $directory_given == no ]] || again+=" --dir $(printf %q "$directory")"
    {
        echo "get-models.sh: error: $url: cannot be downloaded: $1"
        echo "To do it by hand:"
        echo "  1. Open $url with a browser, on any computer."
        echo "  2. Save the file as $target"
        echo "  3. Check it: $again"
        [[ -z $wanted ]] || echo "     It must have the SHA-256 $wanted"
    } >&2
    exit 1
}

no_name="the server's name was not found, expected a network connection"
no_connection="no connection to the server, expected a network connection"
refused="the server refused it"
insecure="no secure connection, expected a server with a valid certificate and a right clock here"
limit=()
status=0
if command -v curl >/dev/null; then
    # A wrong server cannot fill the disk.
    [[ $bytes != - ]] && limit=(--max-filesize "$bytes")
    [[ -t 2 ]] && progress=--progress-bar || progress=--silent
    curl --fail --location --proto "=$protocol" --proto-redir =https --show-error "$progress" \
        --connect-timeout 30 --retry 2 "${limit[@]}" --output "$part" -- "$url" || status=$?
    case $status in
    0) ;;
    5 | 6) cannot_download "$no_name" ;;
    7 | 28 | 52 | 56) cannot_download "$no_connection" ;;
    22) cannot_download "$refused" ;;
    23) fail "$part: cannot be written, expected room on the disk" ;;
    35 | 51 | 53 | 54 | 58 | 59 | 60 | 77 | 83) cannot_download "$insecure" ;;
    63) cannot_download "the server has a larger file, expected $bytes bytes" ;;
    *) cannot_download "curl failed with status $status" ;;
    esac
elif command -v wget >/dev/null; then
    # wget follows a redirection from https to http; only a known hash makes that harmless.
    [[ $url == https://* && -n $wanted ]] ||
        fail "$name cannot be had safely with wget, install curl (apt install curl ca-certificates)"
    wget --no-verbose --tries 3 --timeout 30 --output-document "$part" -- "$url" || status=$?
    case $status in
    0) ;;
    3) fail "$part: cannot be written, expected room on the disk" ;;
    4) cannot_download "$no_connection" ;;
    5) cannot_download "$insecure" ;;
    8) cannot_download "$refused" ;;
    *) cannot_download "wget failed with status $status" ;;
    esac
else
    cannot_download "neither curl nor wget is there, install one (apt install curl ca-certificates)"
fi

check "$part"
[[ -z $problem ]] || fail "what came from $url $problem; nothing was kept"
chmod 644 -- "$part"
# A link refuses to overwrite what another run may have put there meanwhile; not every file system
# has links.
ln -T -- "$part" "$target" 2>/dev/null || mv -n -- "$part" "$target"
[[ -n $wanted ]] || pin
echo "$target is ready."
