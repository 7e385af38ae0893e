#!/usr/bin/env bash
# Installs what is needed, builds everything and runs all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh test
cmake --preset dev
cmake --build --preset dev
ctest --preset dev -j "$(nproc)"
