#!/usr/bin/env bash
# usage: install_test.sh BUILD_DIRECTORY SOURCE COMPILER
set -euo pipefail
build=$1
source=$2
compiler=$3
consumer=$source/tests/install/consumer
example=$source/docs/examples/qt
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix

cmake --install "$build" --prefix "$prefix" >/dev/null
calibration=$prefix/share/altiro3D/calibration/portrait-sample.json
for file in "$calibration" "$prefix/share/altiro3D/models/catalog.json" "$prefix/bin/photo2native" \
    "$prefix/lib/udev/rules.d/70-altiro3D.rules" "$prefix/include/altiro3D/altiro3D.hpp" "$prefix/share/man/man1/photo2native.1" \
    "$prefix/share/bash-completion/completions/photo2native" \
    "$prefix/share/zsh/site-functions/_photo2native" "$prefix/share/doc/altiro3D/README.md" \
    "$prefix/share/doc/altiro3D/docs/guide.md"; do
    [[ -e $file ]] || { echo "not installed: $file"; exit 1; }
done
for document in guide quickstart; do
    for link in $(grep -oP '\]\(\K[^)#:]+(?=[)#])' "$prefix/share/doc/altiro3D/docs/$document.md"); do
        [[ -e $prefix/share/doc/altiro3D/docs/$link ]] || { echo "$document.md: no $link"; exit 1; }
    done
done
libraries=$(dirname "$(find "$prefix" -name 'libaltiro3D.so' -o -name 'libaltiro3D.a' | head -1)")
version=$(sed -n 's/^#define ALTIRO3D_VERSION "\(.*\)"/\1/p' "$prefix/include/altiro3D/version.hpp")
compatible=${version%%.*} # versions with the same number are
[[ $compatible != 0 ]] || compatible=${version%.*}
for library in "$libraries"/libaltiro3D*.so; do
    [[ -e $library ]] || continue # a static one
    name=$(readelf -d "$library" | sed -n 's/.*SONAME.*\[\(.*\)\]/\1/p')
    if [[ $name != "$(basename "$library").$compatible" || ! -e $libraries/$name ]]; then
        echo "$library: the SONAME is $name, expected $(basename "$library").$compatible"
        exit 1
    fi
done

echo "== by find_package"
cmake -G Ninja -S "$consumer" -B "$work/cmake" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
cmake --build "$work/cmake" >/dev/null
LD_LIBRARY_PATH=$libraries "$work/cmake/consumer" "$calibration" >"$work/said"
grep -qF "altiro3D $version" "$work/said" || { cat "$work/said"; exit 1; }
[[ ! -e $libraries/libaltiro3D.so ]] || # asked at run time
    nm -C --undefined-only "$work/cmake/consumer" | grep -qF 'altiro3D::version()'

echo "== the camera loop"
cmake -G Ninja -S "$source/docs/examples/camera" -B "$work/camera" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
cmake --build "$work/camera" >/dev/null
"$prefix/bin/photo2native" --lg "$work/clip.mp4" --turns 1 --seconds 1 --fps 8 \
    "$source/docs/examples/sample.jpg" "$work/filmed.png" >/dev/null
LD_LIBRARY_PATH=$libraries "$work/camera/film_natives" "$calibration" "$work/clip.mp4" "$work/natives.mkv"
[[ $(ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 \
    "$work/natives.mkv") == 1536,2048,8 ]] || { echo "no 8 Natives in natives.mkv"; exit 1; }

module=$(find "$prefix" -path '*/altiro3d/__init__.*.so')
if [[ -n $module ]]; then
    echo "== in Python"
    interpreter=python3
    "$interpreter" -c 'import numpy' 2>/dev/null || interpreter=/usr/bin/python3
    PYTHONPATH=$(dirname "$(dirname "$module")") "$interpreter" -c "
import altiro3d
assert altiro3d.__file__ == '$module' and altiro3d.__version__ == '$version'
altiro3d.read_display('$calibration')"
fi

if [[ -f $libraries/cmake/altiro3D/altiro3DQtTargets.cmake ]]; then
    echo "== with Qt"
    for file in bin/altiro3Dview share/applications/altiro3Dview.desktop \
        share/icons/hicolor/scalable/apps/altiro3D.svg; do
        [[ -e $prefix/$file ]] || { echo "not installed: $file"; exit 1; }
    done
    desktop-file-validate "$prefix/share/applications/altiro3Dview.desktop"
    "$prefix/bin/altiro3Dview" --version
    cmake -G Ninja -S "$example" -B "$work/qt" -DCMAKE_PREFIX_PATH="$prefix" \
        -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
    cmake --build "$work/qt" >/dev/null
    status=0
    QT_QPA_PLATFORM=offscreen LD_LIBRARY_PATH=$libraries "$work/qt/show_native" "$calibration" \
        2>"$work/message" || status=$?
    grep -q "portrait-sample.json: " "$work/message"
    [[ $status == 1 ]]
fi

echo "== as a part of another project"
mkdir "$work/whole"
cat >"$work/whole/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.18)
project(whole LANGUAGES CXX)
set(ALTIRO3D_BUILD_QT ON)
add_subdirectory("$source" altiro3D)
add_executable(whole "$consumer/main.cpp")
target_link_libraries(whole PRIVATE altiro3D::qt)
if(TARGET photo2native OR TARGET altiro3D_unit_tests)
  message(FATAL_ERROR "a part of another project is the library alone")
endif()
CMAKE
cmake -G Ninja -S "$work/whole" -B "$work/whole/build" -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
ninja -C "$work/whole/build" -n whole >"$work/steps" # building it takes minutes
grep -q libaltiro3D_qt "$work/steps"

echo "== by pkg-config"
export PKG_CONFIG_PATH=$libraries/pkgconfig
flags=$(pkg-config --cflags altiro3D)
libs=$(pkg-config --libs altiro3D)
if [[ -e $libraries/libaltiro3D.so ]]; then # what headers show, and nothing else
    named=$(tr ' ' '\n' <<<"$libs" | grep '^-l' | tr '\n' ' ')
    [[ $named == "-laltiro3D -lopencv_core " ]] || { echo "pkg-config --libs names $named"; exit 1; }
fi
# shellcheck disable=SC2086
"$compiler" -std=c++17 $flags "$consumer/main.cpp" -o "$work/plain" $libs
LD_LIBRARY_PATH=$libraries "$work/plain" "$calibration"

echo "== the installed tool"
"$prefix/bin/photo2native" --version
"$prefix/bin/altiro3Dnative" --info "$calibration"
# the prefix is not the one that the build was made for: its own files are found all the same
sed -i 's/1536/768/; s/2048/1024/' "$calibration"
"$prefix/bin/photo2native" -v "$source/docs/examples/sample.jpg" "$work/native.png" >"$work/said"
grep -q "panel 768 x 1024 px" "$work/said" || { cat "$work/said"; exit 1; }
"$prefix/bin/photo2native" "$source/docs/examples/sample.jpg" "$work/native.tif" >/dev/null # by OpenCV
! "$prefix/bin/photo2native" -n no-network "$source/docs/examples/sample.jpg" "$work/b.png" 2>"$work/said"
grep -q "midas-small" "$work/said" || { cat "$work/said"; exit 1; }
! strings -a "$libraries"/libaltiro3D.* "$prefix"/bin/* | grep -F "$source/libaltiro3D/src"
