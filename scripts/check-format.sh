#!/usr/bin/env bash
# Fails if a source file is not formatted as .clang-format says; -i formats them instead.
#
#   scripts/check-format.sh [-i]
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -i -- "$@"
cd "$(dirname "$0")/.."
mode=(--dry-run -Werror)
[[ ${1:-} != -i ]] || mode=(-i)
find bindings libaltiro3D tools tests docs training -name '*.cpp' -print0 -o -name '*.hpp' -print0 |
    xargs -0 clang-format "${mode[@]}"
