#!/usr/bin/env bash
# Compares the symbols that the library exports with a list, so that the ABI does not change by
# accident. Refuses functions of the C library that differ between systems in the last bit.
#
#   exported_symbols_test.sh LIBRARY LIST [--update]
set -euo pipefail
library=$1
list=$2
actual=$(mktemp)
trap 'rm -f "$actual"' EXIT
# Functions and data of namespace altiro3D; weak symbols depend on the compiler.
nm --dynamic --defined-only --demangle "$library" |
    sed -nE 's/^[0-9a-f]+ [TDBR] (.*altiro3D::.*)$/\1/p' | LC_ALL=C sort -u >"$actual"
if [[ ${3:-} == --update ]]; then
    cp "$actual" "$list"
    exit 0
fi
if [[ ! -s $actual ]]; then
    echo "$library: exports nothing, expected the symbols of $list" >&2
    exit 1
fi
if ! diff -u --label expected --label exported "$list" "$actual"; then
    echo "$library: exports other symbols than $list. If the change is intended, run" >&2
    echo "  $0 $library $list --update" >&2
    echo "and, where a symbol went away or changed, raise the minor version (CMakeLists.txt)" >&2
    exit 1
fi
# Those for double are rounded to float, which hides their differences.
if nm --dynamic --undefined-only "$library" | grep -E ' (exp2?|log(2|10)?|pow|hypot|cbrt|a?(sin|cos|tan)|atan2)f(@|$)'; then
    echo "$library: calls these functions for float, expected those for double" >&2
    exit 1
fi
