#!/usr/bin/env bash
# Runs clang-tidy on the sources that differ from a revision (default: where the branch left its
# upstream or, if it has none, the commit before the last), and on one for each header that does,
# or on all of them.
#
#   scripts/check-tidy.sh [--all | REVISION]
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 1 --all -- "$@"
cd "$(dirname "$0")/.."
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >/dev/null
# the fuzz targets need Clang and are in a build of their own
if [[ ! -f build/fuzz/compile_commands.json ]] && command -v clang++ >/dev/null; then
    cmake --preset fuzz >/dev/null
fi
if [[ ${1:-} == --all ]]; then
    mapfile -t files < <(git ls-files 'bindings/*.cpp' 'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
else
    left=$(git merge-base HEAD '@{upstream}' 2>/dev/null) && [[ $left != "$(git rev-parse HEAD)" ]] || left=HEAD~1
    base=${1:-$left}
    git rev-parse --verify -q "$base^{commit}" >/dev/null || base=HEAD
    mapfile -t files < <(git diff --name-only --diff-filter=d "$base" -- \
        'bindings/*.cpp' 'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
    # A header is seen through a source, its own if it has one, even if that did not change.
    while read -r header; do
        name=$(basename "$header" .hpp)
        mapfile -t sources < <(git ls-files "bindings/*/$name.cpp" "libaltiro3D/*/$name.cpp" "tools/*/$name.cpp" "tests/*/$name.cpp")
        if [[ ${#sources[@]} -eq 0 ]]; then # else the first that includes it
            mapfile -t sources < <(git grep -l "[\"/]$name\.hpp\"" -- '*.cpp' | head -n 1)
        fi
        for source in "${sources[@]}"; do
            [[ " ${files[*]} " == *" $source "* ]] || files+=("$source")
        done
    done < <(git diff --name-only --diff-filter=d "$base" -- 'bindings/*.hpp' 'libaltiro3D/*.hpp' 'tools/*.hpp' 'tests/*.hpp')
fi
for build in dev fuzz; do # clang-tidy cannot read precompiled headers of GCC
    [[ -f build/$build/compile_commands.json ]] || continue
    mkdir -p "build/tidy/$build"
    sed 's/-Winvalid-pch -include [^ ]*cmake_pch.hxx//' "build/$build/compile_commands.json" \
        >"build/tidy/$build/compile_commands.json"
done
checked=() # build and file, in turn
for file in "${files[@]}"; do
    build=build/tidy/dev
    [[ $file != tests/fuzz/* ]] || build=build/tidy/fuzz
    if grep -qs "/$file\"" "$build/compile_commands.json"; then
        checked+=("$build" "$file")
    else # programs of their own that no build has, and fuzz targets where there is no Clang
        echo "clang-tidy: $file: skipped: is not in $build/compile_commands.json"
    fi
done
if [[ ${#checked[@]} -eq 0 ]]; then
    echo "clang-tidy: no source differs"
    exit 0
fi
echo "clang-tidy: $((${#checked[@]} / 2)) files"
printf '%s\0' "${checked[@]}" | xargs -0 -n 2 -P "$(nproc)" clang-tidy --quiet -p
