#!/usr/bin/env bash
# Runs the checks for a release: those of .ci/run and the slow ones.
set -euo pipefail
cd "$(dirname "$0")/.."
export ALTIRO3D_LONGEST_TEST=1000 # seconds
scripts/test.sh
ctest --preset dev -j "$(nproc)" -L slow
scripts/check-format.sh
scripts/check-docs.sh
scripts/check-tidy.sh --all
scripts/check-cppcheck.sh

echo "== AddressSanitizer and UndefinedBehaviorSanitizer"
cmake --preset asan
cmake --build --preset asan
ctest --preset asan -j "$(nproc)" -LE install

# Data races: video stages, readers and writers in several threads, the viewer, video2native.
scripts/check-tsan.sh
# Memory errors in five tools, with the kernels for AVX2.
scripts/check-valgrind.sh

echo "== Clang, shared library"
cmake --preset clang
cmake --build --preset clang
ctest --preset clang -j "$(nproc)" -LE install

echo "== GCC and Clang, any instruction set and one processor give the same bytes"
scripts/compare-builds.sh build/dev build/clang

echo "== Kernels for arm64, in an emulator"
scripts/check-arm64.sh

echo "== Tools that are killed 200 times each"
tests/cli/faults_test.sh "$PWD/build/dev/tools" "$PWD" 200

echo "== Fuzzing, ten minutes a target"
scripts/fuzz.sh $((10 * 60 * $(ls tests/fuzz/*_fuzz.cpp | wc -l)))

echo "== Lines of the readers that all inputs so far reach"
scripts/fuzz-coverage.sh

# Shared libraries are those of build/dev and build/clang. Unit tests are skipped: their programs hold
# the library's objects in every build.
for compiler in g++ clang++; do
    echo "== Static library, $compiler: tools, installation, Qt"
    static=build/static-$compiler
    cmake --preset dev -B "$static" -DCMAKE_CXX_COMPILER="$compiler" -DBUILD_SHARED_LIBS=OFF \
        -DALTIRO3D_BUILD_BENCHMARKS=OFF
    cmake --build "$static"
    ctest --test-dir "$static" -j "$(nproc)" --output-on-failure -L 'cli|install|qt'
done

echo "== An hour of work in one process"
scripts/soak.sh

echo "== Chunks on a real Slurm and a real ssh, under faults"
scripts/install-dependencies.sh cluster
for part in slurm ssh; do # a skipped test is a failure here
    tests/cli/cluster_faults_test.sh "$PWD/build/dev/tools" "$PWD" "$part"
done

echo "== Debian packages"
scripts/check-packages.sh
