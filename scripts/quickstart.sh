#!/usr/bin/env bash
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"

usage() {
    cat <<'TEXT'
Usage: scripts/quickstart.sh [--with-midas] [PHOTO [visual.json]]

Installs the packages that are needed to build, builds the tools, and makes native.png, the picture
for the display, from PHOTO (default: the sample photo).

visual.json is the calibration of your display. Without it the tools use the file that
$LKG_CALIBRATION names, visual.json in the current folder, or the display's USB volume. If there is
none, a sample calibration is used.

  --with-midas   download MiDaS 2.1 small (67 MB), a larger depth network; without a network
                 connection the network of altiro3D is used
  -h, --help     show this text
TEXT
}

midas=no
names=()
while (($# > 0)); do
    case $1 in
    -h | --help)
        usage
        exit 0
        ;;
    --with-midas) midas=yes ;;
    --)
        names+=("${@:2}")
        break
        ;;
    -*) wrong_usage "$1: unknown option, expected --with-midas or names of files" ;;
    *) names+=("$1") ;;
    esac
    shift
done
((${#names[@]} <= 2)) || wrong_usage "${names[2]}: one name too many, expected a photo and a visual.json"
for name in "${names[@]}"; do
    if [[ ! -f $name ]]; then
        what="a photo"
        [[ $name != "${names[1]:-}" ]] || what="a calibration (visual.json)"
        echo "$0: $name: does not exist, expected $what" >&2
        exit 1
    fi
done

caller=$PWD
cd "$(dirname "$0")/.."
root=$PWD
tools=$root/build/package/tools
output=$root/quickstart-output
absolute() { (cd "$caller" && realpath -- "$1"); }
photo=$output/sample.jpg
[[ ${#names[@]} -lt 1 ]] || photo=$(absolute "${names[0]}")
calibration=()
[[ ${#names[@]} -lt 2 ]] || calibration=(-c "$(absolute "${names[1]}")")

# shellcheck source=scripts/log.sh
. scripts/log.sh
rm -f "$output/log.txt"
log_to "$output/log.txt"
# its own depth, which lies next to it, shows less of what your photos become
cp -f "$root/docs/examples/sample.jpg" "$output/"
export ALTIRO3D_LOG=$log
echo "This installs the packages that are missing and builds the tools. The first build takes"
echo "$(minutes_here 30). Details go to $log"
scripts/install-dependencies.sh build
echo "Building the tools"
logged cmake --preset package
logged cmake --build --preset package

if [[ $midas == yes ]]; then
    scripts/get-models.sh midas-small ||
        echo "$0: midas-small was not downloaded; the network of altiro3D is used" >&2
fi

echo "Making native.png from $photo"
# where the caller stands: the tools look there for visual.json
(cd "$caller" && "$tools/photo2native" -y -v "${calibration[@]}" --save-quilt "$output/quilt.png" \
    --save-depth "$output/depth.png" -- "$photo" "$output/native.png" >>"$log")
cp -f "$output/native.png" "$root/native.png"

echo
echo "$root/native.png is the picture for your display. On any other screen it looks like a blur."
# shellcheck disable=SC2016 # the reader's shell expands PATH
printf '  Use the tools in this terminal:    export PATH=%q:$PATH\n' "$tools"
printf '  Show it full screen, unscaled:     altiro3Dview --show %q\n' "$root/native.png"
printf '  See the depth without a display:   altiro3Dview %q    and press key 5\n' "$photo"
if grep -q '^depth: network altiro3d' "$log"; then
    printf '  Get a better depth (67 MB, once):  %q midas-small    and run this again\n' \
        "$root/scripts/get-models.sh"
fi
echo "Read on in $root/docs/quickstart.md"
