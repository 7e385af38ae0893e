#!/usr/bin/env bash
# Installs what is needed, builds everything and runs the tests, but not those with the label "slow",
# which scripts/check-all.sh runs. Takes about twelve minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
echo "altiro3D: builds and tests, about twelve minutes on two cores"
scripts/install-dependencies.sh test
cmake --preset dev
cmake --build --preset dev
status=0
# some tests wait most of their time
ctest --preset dev -j "$(($(nproc) + 1))" -LE slow --test-output-size-passed 100000 \
    --output-junit tests.xml || status=$?
scripts/skipped-tests.py build/dev/tests.xml
echo "altiro3D: took $((SECONDS / 60)) min $((SECONDS % 60)) s"
exit "$status"
