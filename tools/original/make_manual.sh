#!/bin/sh
# Makes the manual page of a command here out of its --help, which has paragraphs and then examples,
# with the files and variables of the first tool that it calls; and completions for bash and zsh out of
# those of that tool.
#
#   make_manual.sh TOOLS_DIRECTORY OUTPUT_DIRECTORY COMMAND TOOL...
set -eu
tools=$1
output=$2
command=$3
shift 3

version=$("$tools/$command" --version)
help=$("$tools/$command" --help)
{
    printf '.TH %s 1 "" "altiro3D %s" altiro3D\n' \
        "$(printf '%s' "$command" | tr '[:lower:]' '[:upper:]')" "${version##* }"
    # No character means anything by itself; hyphens stay what people type.
    printf '%s\n' "$help" | sed 's/\\/\\e/g; s/-/\\-/g; s/^[.'\'']/\\\&&/' |
        awk -v RS= -v command="$command" '
            NR == 1 {
                sub(/^Usage: /, "")
                usages = split($0, usage, "\n")
                next
            }
            NR == 2 {
                name = tolower(substr($0, 1, 1)) substr($0, 2)
                gsub(/\n/, " ", name)
                sub(/[:;.].*/, "", name)
                print ".SH NAME\n" command " \\- " name "\n.SH SYNOPSIS"
                for (i = 1; i <= usages; ++i) {
                    sub("^ *" command " ", "", usage[i])
                    print (i == 1 ? "" : ".br\n") ".B " command "\n" usage[i]
                }
                print ".SH DESCRIPTION\n" $0
                next
            }
            /^Examples:/ {
                print ".SH EXAMPLES"
                lines = split($0, line, "\n")
                for (i = 2; i <= lines; ++i) {
                    text = line[i]
                    sub(/^ +/, "", text)
                    print (line[i] ~ /^   /) ? text : ".TP\n\\fB" text "\\fR"
                }
                next
            }
            { print ".PP\n" $0 }'
    "$tools/$1" --help-man | sed -n '/^\.SH FILES/,/^\.SH SEE ALSO/ { /^\.SH SEE ALSO/!p; }'
    echo '.SH SEE ALSO'
    for tool in "$@"; do
        [ "$tool" = "$1" ] || echo ,
        printf '.BR %s (1)' "$tool"
    done
    echo
} >"$output/$command.1"

completion=$("$tools/$1" --help-completion bash)
printf '%s\n' "$completion" | sed "s/$1/$command/g" >"$output/$command"
completion=$("$tools/$1" --help-completion zsh)
printf '%s\n' "$completion" | sed "s/$1/$command/g" >"$output/_$command"
