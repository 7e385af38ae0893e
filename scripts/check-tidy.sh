#!/usr/bin/env bash
# Runs clang-tidy on the sources that differ from a revision (default: the commit before the last),
# or on all of them.
#
#   scripts/check-tidy.sh [--all | REVISION]
set -euo pipefail
cd "$(dirname "$0")/.."
build=build/dev
[[ -f $build/compile_commands.json ]] || cmake --preset dev >/dev/null
if [[ ${1:-} == --all ]]; then
    mapfile -t files < <(git ls-files 'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
else
    base=${1:-HEAD~1}
    git rev-parse --verify -q "$base^{commit}" >/dev/null || base=HEAD
    mapfile -t files < <(git diff --name-only --diff-filter=d "$base" -- \
        'libaltiro3D/*.cpp' 'tools/*.cpp' 'tests/*.cpp')
fi
existing=()
for file in "${files[@]}"; do
    # examples of their own and programs that are not in this build have no compile command
    ! grep -q "/$file\"" "$build/compile_commands.json" || existing+=("$file")
done
[[ ${#existing[@]} -gt 0 ]] || exit 0
echo "clang-tidy: ${#existing[@]} files"
printf '%s\0' "${existing[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$build" --quiet
