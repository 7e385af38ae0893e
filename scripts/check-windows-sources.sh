#!/usr/bin/env bash
# Reads the sources of the library and the tools as MinGW-w64 does, which shows most of what is wrong for
# Windows without a build for it: those that differ from a revision (as scripts/check-tidy.sh), or all. The
# headers of other libraries are this system's. Where MinGW-w64 is not installed, it says so and ends well.
#
#   scripts/check-windows-sources.sh [--all | REVISION]
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 --all -- "$@"
cd "$(dirname "$0")/.."
# shellcheck source=scripts/changed-sources.sh
. scripts/changed-sources.sh
compiler=x86_64-w64-mingw32-g++-posix
if ! command -v $compiler >/dev/null; then
    echo "Windows: skipped: $compiler is not installed (scripts/install-dependencies.sh test)"
    exit 0
fi
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >/dev/null
mapfile -t files < <(changed_sources "${1:-}" libaltiro3D tools | grep -vE '_posix\.cpp$|^tools/original/|^tools/.*/sound_player' || true)
if [[ ${#files[@]} -eq 0 ]]; then
    echo "Windows: no source differs"
    exit 0
fi
# Only these: beside them lie headers of Linux.
headers=build/windows-headers
local=/usr/include/$(gcc -print-multiarch)
mkdir -p $headers
ln -sfn /usr/include/opencv4/opencv2 /usr/include/{nlohmann,hwy,OpenEXR,Imath,libheif,libpng16,lcms2,lcms2_plugin,png,pngconf,pnglibconf,expat,expat_external,turbojpeg,zlib}{,.h} \
    "$local"/{libheif,libav*,libsw*,tiff*.h,zconf.h,expat_config.h,jconfig.h} $headers/ 2>/dev/null || true
find $headers -xtype l -delete
qt=$local/qt5
echo "Windows: ${#files[@]} files"
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" $compiler -std=c++17 -fsyntax-only -Wall -Wextra -Wshadow \
    -Wconversion -Werror -D_WIN32_WINNT=0x0A00 -DUNICODE -DWIN32_LEAN_AND_MEAN -DNOMINMAX -DHWY_SHARED_DEFINE \
    -DALTIRO3D_BUILDS_DLL -DALTIRO3D_LINKS_ALL_FFMPEG -DALTIRO3D_HAVE_HEIF -DALTIRO3D_HAVE_OPENEXR \
    '-DALTIRO3D_SOURCE_DATA_DIR=""' '-DALTIRO3D_INSTALL_DATA_DIR=""' '-DALTIRO3D_INSTALL_DATADIR="share"' \
    '-DALTIRO3D_INSTALL_LIBDIR="lib"' '-DALTIRO3D_INSTALL_BINDIR="bin"' '-DALTIRO3D_SOVERSION="0"' \
    -Ilibaltiro3D -Ilibaltiro3D/src -Ilibaltiro3D/include -Ilibaltiro3D/qt/include -Ibuild/dev/libaltiro3D/include -Itools \
    -isystem $headers -isystem $headers/Imath -isystem $headers/OpenEXR -isystem "$qt" -isystem "$qt/QtCore" -isystem "$qt/QtGui" \
    -isystem "$qt/QtWidgets" -isystem "$qt/QtNetwork"
