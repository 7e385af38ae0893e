# shellcheck shell=bash
# The command lines of scripts; to be sourced before anything else is done.

# Prints the comment at the begin of the script, in which its command lines are indented.
usage() {
    sed -n '2,/^[^#]/{ /^#/!d; s/^# \{0,1\}//; s/^ \{2,\}\(scripts\|docs\|\.ci\)\//Usage: \1\//; p }' "$0"
}

wrong_usage() { # sentence
    echo "$0: $1 (see --help)" >&2
    exit 2
}

check_number() { # argument, what it is
    [[ $1 =~ ^[0-9]+$ ]] || wrong_usage "$1: unknown argument, expected $2"
}

# Answers --help, and refuses unknown options and too many other arguments. Options with values are not
# for it.
check_arguments() { # most arguments without dashes, known options..., --, the script's arguments
    local most=$1 known=() count=0 argument
    shift
    while [[ $1 != -- ]]; do
        known+=("$1")
        shift
    done
    shift
    for argument; do
        case $argument in
        -h | --help)
            usage
            exit 0
            ;;
        -*)
            [[ " ${known[*]} " == *" $argument "* ]] ||
                wrong_usage "$argument: unknown option, expected ${known[*]:-none}"
            ;;
        *)
            count=$((count + 1))
            ((count <= most)) || wrong_usage "$argument: unknown argument, expected $([[ $most == 0 ]] && echo none || echo "$most at most")"
            ;;
        esac
    done
}
