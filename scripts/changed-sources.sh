# shellcheck shell=bash
# For scripts that check sources; to be sourced, in the project's folder.

# Prints the sources (.cpp) below folders that differ from a revision (empty: where the branch left its
# upstream or, if it has none, the commit before the last), and one for each header that does.
changed_sources() { # REVISION or --all or nothing, folder...
    local revision=$1 left base header name source files sources
    shift
    if [[ $revision == --all ]]; then
        git ls-files "${@/%//*.cpp}"
        return
    fi
    left=$(git merge-base HEAD '@{upstream}' 2>/dev/null) && [[ $left != "$(git rev-parse HEAD)" ]] || left=HEAD~1
    base=${revision:-$left}
    git rev-parse --verify -q "$base^{commit}" >/dev/null || base=HEAD
    mapfile -t files < <(git diff --name-only --diff-filter=d "$base" -- "${@/%//*.cpp}")
    # A header is seen through a source, its own if it has one, even if that did not change.
    while read -r header; do
        name=$(basename "$header" .hpp)
        mapfile -t sources < <(git ls-files "${@/%//*/$name.cpp}")
        if [[ ${#sources[@]} -eq 0 ]]; then # else the first that includes it
            mapfile -t sources < <(git grep -l "[\"/]$name\.hpp\"" -- "${@/%//*.cpp}" | head -n 1)
        fi
        for source in "${sources[@]}"; do
            [[ " ${files[*]} " == *" $source "* ]] || files+=("$source")
        done
    done < <(git diff --name-only --diff-filter=d "$base" -- "${@/%//*.hpp}")
    [[ ${#files[@]} -eq 0 ]] || printf '%s\n' "${files[@]}"
}
