#!/usr/bin/env bash
# Builds the library for browsers (WebAssembly) and the page that uses it: build/web/page/, a folder for
# any server of files, and the npm package build/web/altiro3d-*.tgz. OpenCV, Highway, zlib and expat are
# built from Debian's source packages. Needs Debian 12 and the network (180 MB); the first build takes half
# an hour on two cores.
#
#   scripts/build-web.sh            builds
#   scripts/build-web.sh --serve    builds, and serves the page at http://localhost:8000
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 --serve -- "$@"
cd "$(dirname "$0")/.."
serve=
[[ $# -eq 0 ]] || serve=yes
scripts/install-dependencies.sh web
out=$PWD/build/web
log=$out/log
mkdir -p "$out"
# shellcheck source=scripts/log.sh
. scripts/log.sh
log_to "$out/log"
# shellcheck source=scripts/debian-sources.sh
. scripts/debian-sources.sh
export NODE_PATH=/usr/share/nodejs # where Debian has the modules of emcc
jobs=$(nproc)

if [[ ! -e $out/sources/done ]]; then
    echo "Downloading the sources of OpenCV, Highway, zlib and expat"
    rm -rf -- "$out/sources"
    debian_sources "$out/sources" opencv highway zlib expat
    # OpenCV rounds x.5 up on WebAssembly, and to even numbers on other processors.
    rounding=$(ls "$out"/sources/opencv-*/modules/core/include/opencv2/core/hal/intrin_wasm.hpp)
    sed -i 's/trunc_saturate_f32x4(wasm_f32x4_add(a.val, h))/trunc_saturate_f32x4(wasm_f32x4_nearest(a.val))/' \
        "$rounding"
    grep -q 'wasm_f32x4_nearest(a.val))' "$rounding"
    touch "$out/sources/done"
fi

# With threads, also for the module without: bindings/web/CMakeLists.txt.
libraries=$out/libraries
flags='-O3 -msimd128 -pthread -fexceptions'
if [[ ! -e $libraries/done ]]; then
    echo "Building zlib, expat and OpenCV"
    rm -rf -- "$libraries" "$out"/build-{zlib,expat,opencv}
    mkdir -p "$libraries"/{lib,include} "$out"/build-{zlib,expat}
    sed -i 's/^#ifdef HAVE_UNISTD_H.*/#if 1/' "$out"/sources/zlib-*/zconf.h # as its configure does
    # shellcheck disable=SC2086 # several flags
    (cd "$out/build-zlib" && logged emcc $flags -c "$out"/sources/zlib-*/*.c)
    logged emar rcs "$libraries/lib/libz.a" "$out"/build-zlib/*.o
    cp "$out"/sources/zlib-*/{zlib,zconf}.h "$libraries/include/"
    printf '#define %s\n' 'BYTEORDER 1234' 'XML_NS 1' 'XML_CONTEXT_BYTES 1024' 'XML_POOR_ENTROPY 1' \
        >"$out/build-expat/expat_config.h" # the entropy is for servers
    # shellcheck disable=SC2086
    (cd "$out/build-expat" && logged emcc $flags -I. -c "$out"/sources/expat-*/expat/lib/xml{parse,role,tok}.c)
    logged emar rcs "$libraries/lib/libexpat.a" "$out"/build-expat/*.o
    cp "$out"/sources/expat-*/expat/lib/{expat,expat_external}.h "$libraries/include/"
    cp -r "$out"/sources/highway-*/hwy "$libraries/include/"
    off=(ITT OPENCL OPENCLAMDBLAS OPENCLAMDFFT IPP TBB OPENMP LAPACK EIGEN QUIRC ADE JPEG PNG TIFF WEBP OPENJPEG
         JASPER OPENEXR PROTOBUF FFMPEG GSTREAMER GTK V4L VA VA_INTEL 1394 VTK IMGCODEC_HDR IMGCODEC_SUNRASTER
         IMGCODEC_PXM IMGCODEC_PFM)
    off=("${off[@]/#/-DWITH_}")
    off=("${off[@]/%/=OFF}")
    logged emcmake cmake -G Ninja -S "$out"/sources/opencv-*/ -B "$out/build-opencv" "${off[@]}" \
        -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF -DCMAKE_INSTALL_PREFIX="$libraries" \
        -DCMAKE_C_FLAGS="$flags" -DCMAKE_CXX_FLAGS="$flags" -DWITH_PTHREADS_PF=ON \
        -DBUILD_LIST=core,imgproc,photo,calib3d,features2d,flann -DENABLE_PIC=OFF -DCPU_BASELINE= \
        -DCPU_DISPATCH= -DCV_TRACE=OFF -DCV_ENABLE_INTRINSICS=ON -DBUILD_ZLIB=OFF \
        -DZLIB_LIBRARY="$libraries/lib/libz.a" \
        -DZLIB_INCLUDE_DIR="$libraries/include" -DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY \
        -DBUILD_{TESTS,PERF_TESTS,EXAMPLES,DOCS,JAVA,opencv_apps,opencv_python3,opencv_js}=OFF
    logged cmake --build "$out/build-opencv" -j "$jobs" --target opencv_{core,imgproc,photo,calib3d}
    logged cmake --install "$out/build-opencv"
    touch "$libraries/done"
fi

echo "Building the library"
modules=$out/module
logged emcmake cmake -G Ninja -S bindings/web -B "$modules" -DCMAKE_BUILD_TYPE=Release \
    -DOpenCV_DIR="$libraries/lib/cmake/opencv4" -DALTIRO3D_LIBRARIES="$libraries"
logged cmake --build "$modules" -j "$jobs"

echo "Building the package and the page"
mkdir -p "$out/npm"
if ! cmp -s bindings/web/package-lock.json "$out/npm/package-lock.json"; then
    cp bindings/web/package{,-lock}.json "$out/npm/"
    (cd "$out/npm" && logged npm ci --no-audit --no-fund)
    cp bindings/web/package-lock.json "$out/npm/"
fi
package=$out/package
page=$out/page
modules=("$modules"/altiro3d{,-threads}.{js,wasm} "$modules/altiro3d-threads.worker.js")
rm -rf -- "$package" "$page"
mkdir -p "$package" "$page"
logged "$out/npm/node_modules/.bin/tsc" -p bindings/web --noEmit
logged "$out/npm/node_modules/.bin/tsc" -p bindings/web/src --outDir "$package"
cp "${modules[@]}" LICENSE "$package/"
cp bindings/web/package.json "$package/"
(cd "$out" && logged npm pack ./package)
esbuild=("$out/npm/node_modules/.bin/esbuild" --bundle --minify --format=esm --target=es2022
         --alias:altiro3d=./bindings/web/src/index.ts --external:./altiro3d{,-threads}.js --log-level=warning)
export NODE_PATH=$out/npm/node_modules
logged "${esbuild[@]}" bindings/web/page/main.ts --outfile="$page/main.js"
logged "${esbuild[@]}" bindings/web/page/worker.ts --outfile="$page/worker.js" \
    --conditions=onnxruntime-web-use-extern-wasm
cp bindings/web/page/{index.html,page.css,manifest.webmanifest,icon.svg} "${modules[@]}" "$page/"
cp models/altiro3d-depth.onnx "$page/"
engine=$out/npm/node_modules/onnxruntime-web/dist
cp "$engine"/ort-wasm-simd-threaded.{mjs,wasm} "$page/"
files=$(cd "$page" && printf '"%s",' ./ *)
cp "$engine"/{ort.jspi.min.mjs,ort-wasm-simd-threaded.jspi.{mjs,wasm}} "$page/" # kept when they are used
version=$(cd "$page" && cat ./* | sha256sum | cut -c 1-16)
logged "${esbuild[@]}" bindings/web/page/sw.ts --outfile="$page/sw.js" \
    --define:version="\"$version\"" --define:files="[${files%,}]"

size() { # file...: bytes, and bytes as brotli sends them
    local file
    for file; do
        printf '%10d %10d  %s\n' "$(stat -c %s "$file")" "$(brotli -c "$file" | wc -c)" "${file#"$out/"}"
    done
}
echo "     bytes     brotli  (of the first visit: one of the two modules)"
size "$page"/{altiro3d.wasm,altiro3d-threads.wasm,main.js,worker.js,altiro3d-depth.onnx,ort-wasm-simd-threaded.wasm}
size "$page/ort-wasm-simd-threaded.jspi.wasm" # where a network is dropped, and the browser has WebGPU
ls "$out"/altiro3d-*.tgz
if [[ -n $serve ]]; then exec node bindings/web/serve.mjs "$page" 8000; fi
