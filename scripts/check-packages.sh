#!/usr/bin/env bash
# Makes the Debian packages, and installs, uses and removes them on a bare Debian 12, which is made
# with debootstrap in a temporary directory. Needs root, the network and some minutes.
#
#   scripts/check-packages.sh [--made]    --made: takes the packages that are in build/package/
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 --made -- "$@"
cd "$(dirname "$0")/.."
. scripts/bare-debian.sh
[[ ${1:-} == --made ]] || scripts/make-packages.sh
shopt -s nullglob
packages=(build/package/*.deb)
if [[ ${#packages[@]} -ne 6 ]]; then
    echo "$0: build/package: holds ${#packages[@]} packages, expected 6" >&2
    exit 1
fi

make_root bookworm
folder=/made
mkdir "$root/made"
cp "${packages[@]}" docs/examples/sample.jpg docs/examples/sample-depth.png "$root/made/"
cp -r tests/install/consumer docs/examples/qt "$root/made/"

install() { # packages; what apt says matters only if it fails
    inside "apt-get install -q -y --no-install-recommends $1 >/tmp/apt 2>&1 || { cat /tmp/apt; exit 1; }"
}
fail() {
    echo "$0: $*" >&2
    exit 1
}

inside 'apt-get update -q >/dev/null'

echo "== altiro3d: install, make a Native"
install './altiro3d_*.deb ./libaltiro3d[0-9]*.deb'
inside 'test -s /usr/share/doc/altiro3d/README.md && test -s /usr/share/doc/altiro3d/docs/guide.md'
inside 'ldd /usr/bin/photo2native /usr/bin/video2native | { ! grep "not found"; }'
inside 'photo2native sample.jpg native.png 2>&1; photo2native -d sample.jpg sample-depth.png given.tif 2>&1'
inside 'for tool in $(dpkg -L altiro3d | grep ^/usr/bin/.); do "$tool" --version >/dev/null; done'
inside 'test "$(/usr/share/altiro3D/get-models.sh --help | head -c 6)" = "Usage:"'

echo "== altiro3d: map, quilt, videos, view"
inside 'altiro3Dnative -m portrait.map /usr/share/altiro3D/calibration/portrait-sample.json
    photo2native --save-quilt quilt.png sample.jpg with-quilt.png
    quilt2native -m portrait.map quilt_qs8x6a0.75.png from-quilt.png
    quilt2video --seconds 0.5 --turns 1 --fps 8 quilt_qs8x6a0.75.png sway.mp4
    video2native sway.mp4 native.mkv
    native2view native.png view.png
    altiro3Dimage sample.jpg image.png' 2>&1
expect() { # file, what file(1) says of it
    local kind
    kind=$(file -b "$root/made/$1")
    [[ $kind == *"$2"* ]] || fail "$1: is $kind, expected $2"
}
for picture in native with-quilt from-quilt view image; do
    expect "$picture.png" "1536 x 2048"
done
expect given.tif "width=1536"
expect sway.mp4 "ISO Media"
expect native.mkv "Matroska"
# this package is only recommended: a tool that needs it must say so
inside '! timeout 120 video2native --input-format lavfi testsrc=duration=0.2 device.mkv 2>message &&
    grep "capture devices need libavdevice" message'

echo "== altiro3d-viewer: install, start"
install './altiro3d-viewer_*.deb ./libaltiro3d-qt[0-9]*.deb'
inside 'altiro3Dview --version; QT_QPA_PLATFORM=offscreen altiro3Dview --list-displays'

echo "== python3-altiro3d: install, make a Native"
install './python3-altiro3d_*.deb'
cat >"$root/made/use.py" <<'PYTHON'
import altiro3d
display = altiro3d.read_display("/usr/share/altiro3D/calibration/portrait-sample.json")
depth = altiro3d.stored_depth_or(altiro3d.estimated_depth())
native = altiro3d.NativeMaker(display).make_native(depth.read_scene(depth.read_photo("sample.jpg")))
altiro3d.write_image("python.png", native, mark=altiro3d.ImageMark.Native)
PYTHON
inside 'python3 use.py'
expect python.png "1536 x 2048"

echo "== libaltiro3d-dev: install, build a program of one's own"
install './libaltiro3d-dev_*.deb g++ cmake make pkg-config'
inside 'cmake -S consumer -B cmake >/dev/null && cmake --build cmake >/dev/null &&
    cmake/consumer /usr/share/altiro3D/calibration/portrait-sample.json'
inside 'g++ -std=c++17 consumer/main.cpp -o plain $(pkg-config --cflags --libs altiro3D) &&
    ./plain /usr/share/altiro3D/calibration/portrait-sample.json'
install qtbase5-dev
inside 'cmake -S qt -B with-qt >/dev/null && cmake --build with-qt >/dev/null
    status=0
    QT_QPA_PLATFORM=offscreen with-qt/show_native none.png 2>message || status=$?
    cat message
    [[ $status == 1 ]] && grep -q "none.png: " message'

echo "== all: remove"
inside 'dpkg -L $(dpkg-query -W -f "\${Package} " "*altiro3d*") | sort -u >own'
inside 'cp /usr/share/altiro3D/calibration/portrait-sample.json . &&
    dpkg -P python3-altiro3d libaltiro3d-dev altiro3d-viewer altiro3d >/dev/null && ./plain portrait-sample.json'
inside 'dpkg -P $(dpkg-query -W -f "\${Package} " "libaltiro3d*[0-9]") >/dev/null'
while read -r file; do
    [[ -d $root$file && ! -L $root$file ]] && continue # the folder also holds others' files
    [[ ! -e $root$file && ! -L $root$file ]] || fail "$file: stays after dpkg -P"
done <"$root/made/own"
left=$(find "$root"/{usr,etc,opt,var/lib} -iname '*altiro3d*')
[[ -z $left ]] || fail "stays after dpkg -P: $left"
inside '! ldconfig -p | grep -i altiro3d'
echo "the packages are good: installed, used and removed on a bare Debian 12"
