#!/usr/bin/env bash
# Checks that manual pages are valid and name every option, and that shells complete what --help-all names.
#
#   manual_test.sh TOOLS_DIRECTORY
set -euo pipefail
tools=$(cd "$1" && pwd)
manual=$tools/manual
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
fail() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

for need in groff man script; do
    command -v "$need" >/dev/null || { echo "skipped: needs $need"; exit 77; }
done
script -qc true /dev/null >/dev/null 2>&1 || { echo "skipped: needs pseudo-terminals (/dev/pts)"; exit 77; }

# the exit statuses of the guide, which all pages list
statuses=$(grep -oE '^\| [0-9]+ \| ' "$(dirname "$0")/../../docs/guide.md" | tr -dc '0-9\n' | xargs)
[[ $statuses == "0 1 2 130 143" ]] || fail "docs/guide.md: has the exit statuses $statuses"

count=0
for page in "$manual"/*.1; do
    count=$((count + 1))
    tool=$(basename "$page" .1)
    complaints=$(groff -man -ww -z -Tutf8 "$page" 2>&1)
    [[ -z $complaints ]] || fail "$page: groff says $complaints"
    complaints=$(LC_ALL=C.UTF-8 man --warnings -E UTF-8 -l -Tutf8 -Z "$page" 2>&1 >/dev/null)
    [[ -z $complaints ]] || fail "$page: man says $complaints"
    lexgrog "$page" >/dev/null || fail "$page: whatis cannot read its name"
    LC_ALL=C.UTF-8 MANWIDTH=1000 man -E UTF-8 -l "$page" | col -bx >"$work/page"
    bash -n "$manual/$tool" || fail "$manual/$tool: bash cannot read it"
    ! command -v zsh >/dev/null || zsh -n "$manual/_$tool" || fail "$manual/_$tool: zsh cannot read it"
    # a command of the original's has no options of its own, but those of the tool that it calls first
    called=
    if ! grep -q '^\.SH OPTIONS' "$page"; then
        called=$(sed -n '/^\.SH SEE ALSO/,$ s/^\.BR \([^ ]*\) .*/\1/p' "$page" | head -n 1)
        "$tools/$tool" --help | sed '1,/^$/d; /^Examples:/,$d' | awk -v RS= '{ gsub(/\n/, " "); print }' >"$work/paragraphs"
        [[ -s $work/paragraphs ]] || fail "$tool: --help has no text"
        while read -r paragraph; do
            grep -qF -- "$paragraph" "$work/page" || fail "$page: lacks $paragraph"
        done <"$work/paragraphs"
    fi
    names=$("$tools/${called:-$tool}" --help-all | sed -n 's/^  \(-[^ ].*\)/\1/p' | sed 's/   .*//' |
        grep -oE '(^|, )--?[A-Za-z0-9-]+' | tr -d ', ')
    [[ $(wc -w <<<"$names") -ge 5 ]] || fail "$tool: --help-all names no options"
    for section in EXAMPLES FILES ENVIRONMENT "SEE ALSO"; do
        # these two read no variables
        [[ $section == ENVIRONMENT && $tool =~ ^(altiro3Dnative|quilt2video)$ ]] ||
            grep -q "^$section\$" "$work/page" || fail "$page: has no $section"
    done
    listed=$(sed -n '/^EXIT STATUS/,/^SEE ALSO/p' "$work/page" | grep -oE '^ +[0-9]+' | xargs)
    [[ $listed == "$statuses" ]] || fail "$page: has the exit statuses $listed"
    grep -oE '^\.BR [^ ]+' "$page" | cut -c5- | while read -r other; do
        [[ -e $manual/$other.1 || $other == altiro3Dview ]] || echo "$other"
    done >"$work/missing"
    [[ ! -s $work/missing ]] || fail "$page: names $(tr '\n' ' ' <"$work/missing"), which have no page"
    "$tools/$tool" --help | sed '1,/^Examples:/d' | grep "^  $tool " | sed 's/^ *//' >"$work/examples"
    [[ $(wc -l <"$work/examples") -ge 3 ]] || fail "$tool: --help has fewer than 3 examples"
    while read -r example; do
        grep -qF -- "$example" "$work/page" || fail "$page: lacks $example"
        for option in $(tr ' ' '\n' <<<"$example" | grep '^--*[a-z]'); do
            grep -qxF -- "$option" <<<"$names" || fail "$tool: $example: has no option $option"
        done
    done <"$work/examples"
    for name in $names; do
        [[ -n $called ]] || grep -qE "^ +(-.*, )?$name( |,|\$)" "$work/page" || fail "$page: lacks $name"
        grep -qF -- "'$name" "$manual/_$tool" || grep -qE -- "[{,]${name}[,}]" "$manual/_$tool" ||
            fail "$manual/_$tool: lacks $name"
    done
    # every option by itself, typed with its last letter missing
    (
        # shellcheck disable=SC2317
        compopt() { :; }
        # shellcheck disable=SC1090
        source "$manual/$tool"
        for name in $names; do
            COMP_WORDS=("$tool" "$name")
            COMP_CWORD=1
            "_$tool"
            [[ " ${COMPREPLY[*]} " == *" $name "* ]] || echo "$name"
        done
    ) >"$work/missing"
    [[ ! -s $work/missing ]] || fail "$manual/$tool: lacks $(tr '\n' ' ' <"$work/missing")"
done
[[ $count -ge 5 ]] || fail "$manual: holds $count pages"

# As typed: options, their words, names of files with spaces, directories, and nothing where
# anything may stand.
here=$work/here
mkdir -p "$here/pics"
touch "$here/my picture.png" "$here/one.mp4" "$here/pics.png"
{
    echo "PS1="
    echo "source $manual/photo2native; source $manual/video2native"
    # shellcheck disable=SC2016
    echo 'photo2native() { printf "<%s>" "$@"; echo; }'
    echo 'video2native() { photo2native "$@"; }'
    printf 'photo2native -n %s\t\n' midas-s altiro my
    printf 'video2native --preset super\t\n'
    printf 'photo2native --save-q\t q.png --save-v\t p\t my\t --strength o\t --meth\t fa\t -c m\t one\t\nexit\n'
} >"$work/keys"
(cd "$here" && timeout 60 script -qec "bash --norc --noprofile -i" /dev/null <"$work/keys") |
    tr -d '\r' >"$work/screen"
wanted='<--save-quilt><q.png><--save-views><pics/><my picture.png><--strength><o><--method><fast><-c><my picture.png><one.mp4>'
grep -qF "$wanted" "$work/screen" || fail "typed: $(cat "$work/screen")"

if command -v zsh >/dev/null; then
    {
        echo "PS1=; fpath=($manual \$fpath); autoload -Uz compinit; compinit -u -D"
        sed -n '/^photo2native()/p; /^video2native()/p; / -n /p; / --preset /p' "$work/keys"
        echo exit
    } >"$work/zsh-keys"
    (cd "$here" && timeout 60 script -qec "zsh -f -i" /dev/null <"$work/zsh-keys") |
        tr -d '\r' >"$work/zsh-screen"
fi
for wanted in '<-n><midas-small>' '<-n><altiro3d>' '<-n><my picture.png>' '<--preset><superfast>'; do
    for screen in screen zsh-screen; do
        [[ ! -e $work/$screen ]] || grep -qF -- "$wanted" "$work/$screen" ||
            fail "typed: $(cat -v "$work/$screen")"
    done
done

[[ $failures -eq 0 ]] && echo "ok: $count tools"
