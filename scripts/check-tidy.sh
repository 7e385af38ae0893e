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
# shellcheck source=scripts/changed-sources.sh
. scripts/changed-sources.sh
[[ -f build/dev/compile_commands.json ]] || cmake --preset dev >/dev/null
# the fuzz targets need Clang and are in a build of their own
if [[ ! -f build/fuzz/compile_commands.json ]] && command -v clang++ >/dev/null; then
    cmake --preset fuzz >/dev/null
fi
mapfile -t files < <(changed_sources "${1:-}" bindings libaltiro3D tools tests)
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
