#!/usr/bin/env bash
# Builds the library's documentation; a Doxygen warning is a failure.
#
#   scripts/check-docs.sh
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
mkdir -p build/docs
doxygen docs/Doxyfile >/dev/null
echo "documentation: build/docs/html/index.html"
