#!/usr/bin/env bash
# Builds the libraries that altiro3D uses for 64-bit Windows, from Debian's source packages, into
# build/windows/libraries. Those that are there are left out. Takes two hours on two cores, half of it Qt.
#
#   scripts/windows-libraries.sh             all of them
#   scripts/windows-libraries.sh LIBRARY...  some: opencv, ffmpeg, qt ... (the functions below)
#
# WINDOWS_X264=no builds FFmpeg without x264, whose licence is the GPL, into libraries/without-x264: there is no
# encoder of H.264 then.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 20 --one -- "$@"
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh windows
out=$PWD/build/windows
sources=$out/sources
libraries=$out/libraries
host=x86_64-w64-mingw32
export ALTIRO3D_WINDOWS_LIBRARIES=$libraries PKG_CONFIG_LIBDIR=$libraries/lib/pkgconfig PKG_CONFIG_PATH=
jobs=$(nproc)
toolchain=$PWD/cmake/windows.cmake
vectors=-Wa,-muse-unaligned-vector-move # see windows.cmake
mkdir -p "$libraries"/{lib/pkgconfig,include,done} "$out/objects"
# shellcheck source=scripts/log.sh
. scripts/log.sh
log_to "$out/log"
# shellcheck source=scripts/debian-sources.sh
. scripts/debian-sources.sh

source_of() { # package
    local folder
    for folder in "$sources/$1"-*/; do echo "${folder%/}"; done
}
by_cmake() { # folder option...
    local folder=$1
    shift
    cmake -G Ninja -S "$folder" -B . -DCMAKE_TOOLCHAIN_FILE="$toolchain" -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_INSTALL_PREFIX="$libraries" -DBUILD_SHARED_LIBS=OFF "$@"
    ninja -j "$jobs" install
}
by_configure() { # folder option...
    local folder=$1
    shift
    CC=$host-gcc-posix CFLAGS="-O2 $vectors" CPPFLAGS=-I$libraries/include LDFLAGS=-L$libraries/lib \
        "$folder/configure" --host=$host --prefix="$libraries" "$@"
    make -j "$jobs" install
}

build_zlib() { # Debian has it
    cp /usr/$host/include/{zlib,zconf}.h "$libraries/include/"
    cp /usr/$host/lib/libz.a "$libraries/lib/"
    printf '%s\n' 'Name: zlib' 'Description: zlib' 'Version: 1.2.13' "Libs: -L$libraries/lib -lz" \
        "Cflags: -I$libraries/include" >"$libraries/lib/pkgconfig/zlib.pc"
}
build_json() { # only headers
    cp -r /usr/include/nlohmann "$libraries/include/"
    mkdir -p "$libraries/share/cmake"
    cp -r /usr/share/cmake/nlohmann_json "$libraries/share/cmake/"
}
build_gtest() { by_cmake /usr/src/googletest -DBUILD_GMOCK=OFF; } # the unit tests' (scripts/check-windows.sh)
build_png() { by_cmake "$(source_of libpng1.6)" -DPNG_{SHARED,TESTS}=OFF; }
build_jpeg() { by_cmake "$(source_of libjpeg-turbo)" -DENABLE_SHARED=OFF -DREQUIRE_SIMD=ON; }
build_webp() {
    by_cmake "$(source_of libwebp)" \
        -DWEBP_BUILD_{ANIM_UTILS,CWEBP,DWEBP,GIF2WEBP,IMG2WEBP,VWEBP,WEBPINFO,WEBPMUX,EXTRAS}=OFF
}
build_tiff() {
    by_cmake "$(source_of tiff)" -Dtiff-{tools,tests,contrib,docs}=OFF -D{lzma,zstd,jbig,lerc,libdeflate,webp,cxx}=OFF
}
build_lcms2() { by_configure "$(source_of lcms2)" --disable-shared --without-{jpeg,tiff}; }
build_expat() {
    local expat
    expat=$(source_of expat)/expat
    # a patch of Debian's asks for the value 1
    sed -i 's/^#cmakedefine \(XML_DTD\|XML_GE\) *$/#cmakedefine \1 1/' "$expat/expat_config.h.cmake"
    by_cmake "$expat" -DEXPAT_BUILD_{TOOLS,EXAMPLES,TESTS,DOCS}=OFF -DEXPAT_SHARED_LIBS=OFF
}
build_highway() { by_cmake "$(source_of highway)" -DHWY_ENABLE_{TESTS,EXAMPLES,CONTRIB}=OFF -DBUILD_TESTING=OFF; }
build_imath() { by_cmake "$(source_of imath)" -DBUILD_TESTING=OFF -DIMATH_INSTALL_PKG_CONFIG=ON; }
build_openexr() { by_cmake "$(source_of openexr)" -DBUILD_TESTING=OFF -DOPENEXR_INSTALL_PKG_CONFIG=ON -DOPENEXR_{BUILD_TOOLS,INSTALL_{EXAMPLES,TOOLS}}=OFF; }
build_protobuf() {
    by_cmake "$(source_of protobuf)" -Dprotobuf_{BUILD_{TESTS,PROTOC_BINARIES,EXAMPLES},WITH_ZLIB,MSVC_STATIC_RUNTIME}=OFF
}
build_opencv() {
    local off=(ITT OPENCL OPENCLAMDBLAS OPENCLAMDFFT IPP TBB OPENMP LAPACK EIGEN QUIRC ADE OPENJPEG JASPER OPENEXR
        FFMPEG GSTREAMER DSHOW MSMF MSMF_DXVA DIRECTX VTK WIN32UI GTK 1394 VULKAN OBSENSOR)
    off=("${off[@]/#/-DWITH_}")
    # CVAPI_EXPORTS: a DLL that contains these static libraries exports their functions. HAVE_PTHREAD: it
    # does not look for threads here. Results are those of Debian's own library: the same instructions of the
    # processor, and functions for float by their short names (math.h), which inpainting calls.
    by_cmake "$(source_of opencv)" "${off[@]/%/=OFF}" -DCMAKE_C_FLAGS="-DCVAPI_EXPORTS $vectors" \
        -DCMAKE_CXX_FLAGS="-DCVAPI_EXPORTS -include math.h $vectors" \
        -DBUILD_LIST=core,imgproc,imgcodecs,photo,calib3d,features2d,flann,dnn,video \
        -DCPU_BASELINE=SSE2 -DCPU_BASELINE_DISABLE=SSE3 \
        -DHAVE_PTHREAD=1 -DWITH_PTHREADS_PF=ON -DBUILD_{ZLIB,PNG,JPEG,TIFF,WEBP,PROTOBUF}=OFF \
        -DPROTOBUF_UPDATE_FILES=ON -D{Protobuf,PROTOBUF}_PROTOC_EXECUTABLE=/usr/bin/protoc \
        -DProtobuf_INCLUDE_DIR="$libraries/include" -DProtobuf_LIBRAR{Y,IES}="$libraries/lib/libprotobuf.a" \
        -DBUILD_{TESTS,PERF_TESTS,EXAMPLES,DOCS,JAVA,opencv_apps,opencv_python3,opencv_python2,opencv_js}=OFF \
        -DCV_TRACE=OFF -DENABLE_PRECOMPILED_HEADERS=OFF
    find "$libraries" -name 'OpenCVModules*.cmake' -exec sed -i "s|protobuf::libprotobuf|$libraries/lib/libprotobuf.a|g" {} +
}
build_x264() {
    "$(source_of x264)/configure" --host=$host --cross-prefix=$host- --prefix="$libraries" --enable-static \
        --disable-{cli,opencl} --bit-depth=8
    make -j "$jobs" install
}
build_dav1d() {
    printf '%s\n' '[binaries]' "c = '$host-gcc-posix'" "cpp = '$host-g++-posix'" "ar = '$host-ar'" \
        "strip = '$host-strip'" "windres = '$host-windres'" "pkgconfig = 'pkg-config'" "nasm = 'nasm'" \
        '[properties]' 'needs_exe_wrapper = true' '[built-in options]' "c_args = ['$vectors']" '[host_machine]' \
        "system = 'windows'" "cpu_family = 'x86_64'" "cpu = 'x86_64'" "endian = 'little'" >meson.cross
    meson setup . "$(source_of dav1d)" --cross-file meson.cross --prefix "$libraries" --libdir lib \
        --buildtype release --default-library static -Denable_tools=false -Denable_tests=false
    ninja -j "$jobs" install
}
build_de265() { by_cmake "$(source_of libde265)" -DENABLE_{SDL,DECODER,ENCODER}=OFF; }
build_heif() {
    by_cmake "$(source_of libheif)" -DWITH_{AOM,X265,RAV1E,SvtEnc,EXAMPLES}=OFF -DENABLE_PLUGIN_LOADING=OFF \
        -DWITH_{DAV1D,LIBDE265}=ON -DWITH_AOM_{DECODER,ENCODER}=OFF -DWITH_{DAV1D,LIBDE265}_PLUGIN=OFF \
        -DBUILD_TESTING=OFF -DCMAKE_CXX_FLAGS="-DLIBDE265_STATIC_BUILD $vectors"
}
ffmpeg_into() { # folder option... : all it reads, and what the tools write
    local folder=$1
    shift
    "$(source_of ffmpeg)/configure" --arch=x86_64 --target-os=mingw32 --cross-prefix=$host- --enable-cross-compile \
        --cc=$host-gcc-posix --cxx=$host-g++-posix --prefix="$folder" --pkg-config=pkg-config \
        --pkg-config-flags=--static --extra-cflags="-I$libraries/include $vectors" --extra-ldflags="-L$libraries/lib" \
        --enable-static --disable-{shared,autodetect,programs,doc,debug,network,encoders,muxers,filters,protocols,outdevs,indevs} \
        --enable-{libdav1d,zlib} \
        --enable-encoder=ffv1,prores_ks,rawvideo,mjpeg,png,aac,flac,'pcm_*',ass,ssa,subrip,srt,mov_text,webvtt \
        --enable-muxer=mov,mp4,matroska,webm,avi,yuv4mpegpipe,rawvideo,wav,null \
        --enable-protocol=file,pipe,fd,crypto,data,concat,subfile \
        --enable-filter=bwdif,scale,format,buffer,buffersink,null,aresample,aformat --enable-indev=dshow,gdigrab "$@"
    make -j "$jobs" install
}
build_ffmpeg() { ffmpeg_into "$libraries" --enable-gpl --enable-libx264 "--enable-encoder=libx264,libx264rgb"; }
build_ffmpeg-without-x264() { ffmpeg_into "$libraries/without-x264"; }
build_sdl2() { # the viewer's sound, loaded when it is needed
    by_cmake "$(source_of libsdl2)" -DSDL_{SHARED=ON,STATIC=OFF,TEST=OFF,JOYSTICK=OFF,HAPTIC=OFF,SENSOR=OFF}
    sed -i 's/-lmingw32 -mwindows -lSDL2main//; s/-Dmain=SDL_main//' "$libraries/lib/pkgconfig/sdl2.pc" # Qt has the begin
}
build_qt() {
    local off=(sql testlib concurrent dbus xml pdf printer bearermanagement direct2d
        tabletevent) # Debian has no wintab.h
    sed -i "s/-lSecur32/-lsecur32/; s/-lCrypt32/-lcrypt32/" "$(source_of qtbase-opensource-src)/src/network/ssl/ssl.pri" # as MinGW names them
    "$(source_of qtbase-opensource-src)/configure" -xplatform win32-g++ -device-option CROSS_COMPILE=$host- \
        -prefix "$libraries/qt" -opensource -confirm-license -release -shared -nomake examples -nomake tests \
        -no-{opengl,dbus,icu,openssl,compile-examples} \
        -external-hostbindir /usr/lib/qt5/bin -schannel -qt-{zlib,pcre,doubleconversion,freetype,harfbuzz,libpng,libjpeg} \
        "${off[@]/#/-no-feature-}"
    make -j "$jobs"
    make install
    ln -sf /usr/lib/qt5/bin/{moc,rcc,uic,qmake} "$libraries/qt/bin/" # where CMake looks for them
}

if [[ ${1:-} == --one ]]; then
    mkdir -p "$out/objects/$2"
    cd "$out/objects/$2"
    "build_$2"
    exit
fi
packages=(libpng1.6 libjpeg-turbo tiff lcms2 expat highway imath openexr opencv ffmpeg x264 libheif libde265 dav1d
          qtbase-opensource-src protobuf libwebp libsdl2)
if [[ ! -e $libraries/done/sources ]]; then
    echo "Downloading the sources of ${packages[*]}"
    rm -rf -- "$sources"
    debian_sources "$sources" "${packages[@]}"
    touch "$libraries/done/sources"
fi
ffmpeg=(x264 ffmpeg)
[[ ${WINDOWS_X264:-yes} == yes ]] || ffmpeg=(ffmpeg-without-x264)
wanted=("$@")
[[ $# -gt 0 ]] || wanted=(qt sdl2 zlib json gtest png jpeg webp tiff lcms2 expat highway imath openexr protobuf
                          opencv dav1d de265 heif "${ffmpeg[@]}")
for library in "${wanted[@]}"; do
    stamp=$libraries/done/$library
    [[ ! -e $stamp ]] || continue
    begin=$SECONDS
    rm -rf -- "$out/objects/$library"
    echo "Building $library"
    # a process of its own: the shell ends a function at the first failed command only outside of a condition
    logged "$PWD/scripts/windows-libraries.sh" --one "$library"
    touch "$stamp"
    echo "$library: $((SECONDS - begin)) s" | tee -a "$out/times"
done
