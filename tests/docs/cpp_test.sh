#!/usr/bin/env bash
# Compiles the C++ of the documents (```cpp or ```c++), and runs what is a whole program.
#
#   cpp_test.sh SOURCE_DIRECTORY LIBRARY OPENCV_CORE COMPILER FLAG...
#
# A block with `int main` stands alone: it is linked and run in a folder that holds holiday.jpg and
# visual.json (a Portrait's). The .png files that it names must then be there; what is named native
# has the panel's size.
# Any other block is a fragment: it gets altiro3D.hpp and a function around all but its #includes.
# A static LIBRARY is not linked with: it would need its own libraries.
set -euo pipefail
source=$1
library=$2
opencv=$3
compiler=("${@:4}" -std=c++17 -Wall -Wextra -Werror)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Writes each block of some documents into DIRECTORY/NUMBER.cpp; messages name the document's lines.
blocks_of() { # DIRECTORY DOCUMENT...
    mkdir "$1"
    awk -v directory="$1" '
        FNR == 1 { file = "" }
        /^ *```/ { file = "" }
        /^ *```(cpp|c\+\+) *$/ {
            file = directory "/" ++count ".cpp"
            printf "#line %d \"%s\"\n", FNR + 1, FILENAME >file
            next
        }
        file { print >file }
    ' "${@:2}"
}

is_program() { grep -q 'int main' "$1"; } # BLOCK

compiles() { # BLOCK
    if ! is_program "$1"; then
        {
            echo '#include <altiro3D/altiro3D.hpp>'
            sed -n '/^#include/p' "$1"
            echo 'void fragment() {'
            sed 's/^#include.*//' "$1"
            echo '}'
        } >"$1.whole"
        mv "$1.whole" "$1"
    fi
    "${compiler[@]}" -fsyntax-only "$1"
}

runs() { # BLOCK
    local here=${1%.cpp} names name panel
    mkdir "$here"
    cp "$source/docs/examples/sample.jpg" "$here/holiday.jpg"
    cp "$source/calibration/portrait-sample.json" "$here/visual.json"
    "${compiler[@]}" "$1" "$library" -Wl,-rpath,"$(dirname "$library")" "$opencv" \
        -o "$here/program" && (cd "$here" && ./program) || return 1
    panel="0 0 6 0 0 0 8 0" # 1536 x 2048, as PNG writes it
    names=$(grep -oE '"[^"]+\.png"' "$1" | tr -d '"' | sort -u)
    for name in $names; do
        [[ -s $here/$name ]] || { echo "$name was not written"; return 1; }
        [[ $name != native.png || $(od -An -tu1 -j16 -N8 "$here/$name" | xargs) == "$panel" ]] ||
            { echo "$name has not the panel's size"; return 1; }
    done
}

# Whether all blocks of some documents work; at least one is there.
works() { # DIRECTORY DOCUMENT...
    local block programs=0
    blocks_of "$@"
    set -- "$1"/*.cpp
    [[ -e $1 ]] || { echo "no C++ in the documents"; return 1; }
    for block; do
        compiles "$block" || return 1
        if is_program "$block" && [[ $library != *.a ]]; then
            runs "$block" || { sed -n 's/^#line/does not run:/p' "$block"; return 1; }
            programs=$((programs + 1))
        fi
    done
    echo "$# blocks of C++, $programs of them run"
}

cd "$source"
works "$work/blocks" ./*.md {libaltiro3D,models,calibration,docs}/*.md

# A fragment passes, and what has a fault does not.
cat >"$work/fragment.md" <<'TEXT'
```cpp
#include <string>
const std::string name = "native.png";
const cv::Mat native = altiro3D::readPhoto(name);
```
TEXT
works "$work/fragment" "$work/fragment.md" >/dev/null
fails() { # WHY, C++ on standard input
    { echo '```cpp'; cat; echo '```'; } >"$work/$1.md"
    ! works "$work/$1" "$work/$1.md" >"$work/said" 2>&1 ||
        { echo "FAILED: a document passes whose C++ has a fault: $1"; exit 1; }
}
echo 'altiro3D::noSuchFunction();' | fails unknown
echo 'const cv::Mat photo = altiro3D::readPhoto(1);' | fails types
if [[ $library != *.a ]]; then
    echo 'int main() { return 1; }' | fails status
    echo 'int main() { return *"native.png" == 0; }' | fails nothing-written
fi
echo '# no C++' >"$work/none.md"
! works "$work/none" "$work/none.md" >"$work/said"
