#!/usr/bin/env bash
# Runs clang-tidy on the sources that differ from a revision (default: the commit before the last),
# or on all of them.
#
#   scripts/check-tidy.sh [--all | REVISION]
set -euo pipefail
cd "$(dirname "$0")/.."
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >/dev/null
# the fuzz targets need Clang and are in a build of their own
if [[ ! -f build/fuzz/compile_commands.json ]] && command -v clang++ >/dev/null; then
    cmake --preset fuzz >/dev/null
fi
if [[ ${1:-} == --all ]]; then
    mapfile -t files < <(git ls-files 'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
else
    base=${1:-HEAD~1}
    git rev-parse --verify -q "$base^{commit}" >/dev/null || base=HEAD
    mapfile -t files < <(git diff --name-only --diff-filter=d "$base" -- \
        'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
fi
checked=() # build and file, in turn
for file in "${files[@]}"; do
    build=build/dev
    [[ $file != tests/fuzz/* ]] || build=build/fuzz
    if grep -qs "/$file\"" "$build/compile_commands.json"; then
        checked+=("$build" "$file")
    else # programs of their own that no build has, and fuzz targets where there is no Clang
        echo "clang-tidy: $file: skipped: is not in $build/compile_commands.json"
    fi
done
[[ ${#checked[@]} -gt 0 ]] || exit 0
echo "clang-tidy: $((${#checked[@]} / 2)) files"
printf '%s\0' "${checked[@]}" | xargs -0 -n 2 -P "$(nproc)" clang-tidy --quiet -p
