#!/usr/bin/env bash
# scripts/skipped-tests.py counts what ctest skipped, by reason. usage: skipped_tests_test.sh SOURCE_DIRECTORY
set -euo pipefail
script=$1/scripts/skipped-tests.py
for need in python3 ctest; do
    command -v "$need" >/dev/null || { echo "skipped: needs $need"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/build"
cd "$work/build"

add() { # name, shell command
    echo "add_test($1 bash -c [==[$2]==])"
    echo "set_tests_properties($1 PROPERTIES SKIP_RETURN_CODE 77" \
        "SKIP_REGULAR_EXPRESSION [==[\[  SKIPPED \]]==])"
}
gtest_skips() { # message; what GoogleTest prints
    echo "echo '[ RUN      ] A.B'; echo '/src/a_test.cpp:9: Skipped'; echo '$1'; echo; echo '[  SKIPPED ] A.B (0 ms)'"
}
data="of the test data: set ALTIRO3D_TEST_DATA to its folder"
{
    add passes "echo fine"
    add data1 "$(gtest_skips "needs photos/a.jpg $data")"
    add data2 "$(gtest_skips "needs videos $data")"
    add data3 "$(gtest_skips "needs videos $data")"
    add data4 "$(gtest_skips "needs quilts/x.png $data")"
    add full "$(gtest_skips "needs /dev/full")"
    add shell "echo 'SKIPPED: needs xdotool'; exit 77"
    add silent "exit 77"
    add fails "exit 1"
    echo "add_test(many bash -c [==[$(gtest_skips "needs /dev/full"); $(gtest_skips "needs a tea")]==])"
} >CTestTestfile.cmake
ctest --output-junit junit.xml >"$work/said" 2>&1 || true
"$script" junit.xml >"$work/found"
diff - "$work/found" <<'TEXT'
9 tests were skipped:
  4: needs the test data, which is not in the repository: set ALTIRO3D_TEST_DATA to its folder
  2: needs /dev/full (full, one of many)
  1: needs xdotool (shell)
  1: no reason given (silent)
  1: needs a tea (one of many)
TEXT

add passes "echo fine" >CTestTestfile.cmake
ctest --output-junit junit.xml >"$work/said" 2>&1
diff <("$script" junit.xml) - <<<"0 tests were skipped."

status=0
"$script" none.xml 2>"$work/message" || status=$?
[[ $status == 1 && $(wc -l <"$work/message") == 1 ]] || { cat "$work/message"; exit 1; }
echo "all passed"
