#!/usr/bin/env bash
# Installs what is needed, builds everything and runs the tests, but not those with the label "slow",
# which scripts/check-all.sh runs.
#
#   scripts/test.sh
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
. scripts/log.sh
echo "altiro3D: builds and tests, $(minutes_here 40) if nothing is built yet"
export NINJA_STATUS='[%f/%t, %p, %e s] '
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
