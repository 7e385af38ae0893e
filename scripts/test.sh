#!/usr/bin/env bash
# Installs what is needed, builds everything and runs all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh test
cmake --preset dev
cmake --build --preset dev
status=0
ctest --preset dev -j "$(nproc)" --output-junit tests.xml || status=$?
scripts/skipped-tests.py build/dev/tests.xml
exit "$status"
