#!/usr/bin/env bash
# Builds the library's documentation; a Doxygen warning is a failure.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p build/docs
doxygen docs/Doxyfile >/dev/null
echo "documentation: build/docs/html/index.html"
