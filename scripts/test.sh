#!/usr/bin/env bash
# Installs what is needed, builds everything and runs all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh test
cmake --preset dev
cmake --build --preset dev
status=0
# some tests wait most of their time
ctest --preset dev -j "$(($(nproc) + 1))" --output-junit tests.xml || status=$?
scripts/skipped-tests.py build/dev/tests.xml
exit "$status"
