#!/usr/bin/env bash
# Builds the library for browsers and its page (scripts/build-web.sh), and checks both in headless
# Chromium: the same pixels as photo2native, memory, saving, full screen, offline, broken files. Exits
# with 77 where Emscripten is not installed (scripts/install-dependencies.sh web).
#
#   scripts/check-web.sh [WORD...]    checks whose names contain a word; default: all
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 99 -- "$@"
cd "$(dirname "$0")/.."
if ! command -v emcc >/dev/null; then
    echo "$0: emcc: is not there, expected Emscripten (scripts/install-dependencies.sh web)" >&2
    exit 77
fi
scripts/build-web.sh
cmake --preset dev >/dev/null
cmake --build --preset dev --target photo2native
node bindings/web/tests/check.mjs build/web build/dev/tools/photo2native docs/examples "$@"
