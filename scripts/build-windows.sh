#!/usr/bin/env bash
# Builds altiro3D for 64-bit Windows: build/windows/altiro3D-VERSION-windows-x64.zip and -setup.exe. Needs
# Debian 12 and the network (300 MB); the first build takes two to three hours on two cores, most of it for the
# libraries (scripts/windows-libraries.sh), a later one some minutes.
#
#   scripts/build-windows.sh
#
# WINDOWS_X264=no leaves x264 out, whose licence is the GPL: H.264 is not written then, and the names end in
# -without-x264.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
scripts/windows-libraries.sh
out=$PWD/build/windows
libraries=$out/libraries
variant=
[[ ${WINDOWS_X264:-yes} == yes ]] || variant=-without-x264
tools=$out/tools$variant
export ALTIRO3D_WINDOWS_LIBRARIES=$libraries PKG_CONFIG_LIBDIR=$libraries/lib/pkgconfig
export PKG_CONFIG_PATH=${variant:+$libraries/without-x264/lib/pkgconfig} # before those
# shellcheck source=scripts/log.sh
. scripts/log.sh
log_to "$out/log"

echo "Building the tools, $(minutes_here 40) if nothing is built yet"
rsvg-convert --width 256 --height 256 --output "$out/icon.png" tools/viewer/altiro3D.svg
scripts/make-icon.py "$out/icon.png" "$out/altiro3D.ico"
logged cmake -G Ninja -S . -B "$tools" -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/windows.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DALTIRO3D_BUILD_{TESTS,BENCHMARKS,PYTHON}=OFF -DALTIRO3D_DATA_FROM_SOURCE=OFF \
    -DALTIRO3D_WITH_ONNXRUNTIME=OFF -DALTIRO3D_WINDOWS_ICON="$out/altiro3D.ico"
logged cmake --build "$tools" -j "$(nproc)"
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:.*=//p' "$tools/CMakeCache.txt")
folder=$out/altiro3D-$version-windows-x64$variant
rm -rf -- "$folder"
for component in runtime library viewer; do
    logged cmake --install "$tools" --strip --prefix "$folder" --component "$component"
done

# Qt with the libraries of its compiler, and the sound of the viewer
cp /usr/lib/gcc/x86_64-w64-mingw32/12-posix/{libgcc_s_seh-1,libstdc++-6}.dll /usr/x86_64-w64-mingw32/lib/libwinpthread-1.dll \
    "$folder/bin/"
cp "$libraries"/qt/bin/Qt5{Core,Gui,Network,Widgets}.dll "$libraries/bin/SDL2.dll" "$folder/bin/"
for plugin in platforms/qwindows styles/qwindowsvistastyle imageformats/qjpeg; do
    mkdir -p "$folder/bin/plugins/${plugin%/*}"
    cp "$libraries/qt/plugins/$plugin.dll" "$folder/bin/plugins/$plugin.dll"
done
printf '%s\n' '[Paths]' 'Plugins = plugins' >"$folder/bin/qt.conf"
find "$folder/bin" -name '*.dll' -exec x86_64-w64-mingw32-strip --strip-unneeded {} +

# The documents as pages, whose links are to pages
mkdir -p "$folder/manual"
cp -r docs/images docs/examples "$folder/manual/"
for document in README.md docs/{CHANGELOG,cluster,depth,guide,layered,python,quickstart,reliability,tradeoff}.md; do
    name=$(basename "$document" .md)
    pandoc --from gfm --to html5 --standalone --metadata title="altiro3D: $name" "$document" |
        sed -E 's|href="(docs/)?([a-z]+)\.md|href="\2.html|g; s|src="docs/|src="|g' >"$folder/manual/$name.html"
done
rm -rf -- "$folder/share/doc" # what the viewer shows stays
cp "$out/altiro3D.ico" "$folder/"
sed 's/$/\r/' LICENSE >"$folder/LICENSE.txt"
licences=$folder/share/licences
mkdir -p "$licences"
for licence in "$out"/sources/*/debian/copyright; do
    name=$(basename "${licence%/debian/copyright}")
    cp "$licence" "$licences/${name%%-[0-9]*}.txt"
done
cp /usr/share/doc/g++-mingw-w64-x86-64-posix/copyright "$licences/gcc.txt"
gpl="altiro3D.dll contains x264, whose licence is the GNU General Public License: who hands this
folder on hands it on under that licence."
if [[ -n $variant ]]; then
    gpl="There is no encoder of H.264 inside: video2native needs --codec ffv1 or prores."
    rm "$licences/x264.txt"
fi
sed 's/$/\r/' >"$folder/README.txt" <<TEXT
altiro3D $version for 64-bit Windows 10 and 11. Experimental: it was tried with Wine, and nothing on Windows.

    bin\\altiro3Dview.exe                        the window
    bin\\photo2native.exe PHOTO native.png       makes the picture for a lenticular display
    manual\\README.html                          the documents

The folder can be moved; the programs need nothing outside of it. share\\licences holds the licences of the
libraries inside. $gpl
The sources are Debian 12's, and those of altiro3D.
TEXT
(cd "$out" && rm -f "$(basename "$folder")"{.zip,-setup.exe} && zip -qr9 "$(basename "$folder").zip" "$(basename "$folder")")
logged makensis -V2 "-DVERSION=$version" "-DFOLDER=$folder" "-DOUT=$folder-setup.exe" cmake/windows/setup.nsi
ls -sh "$folder.zip" "$folder-setup.exe"
