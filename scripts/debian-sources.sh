# shellcheck shell=bash
# For scripts that build libraries for other systems; to be sourced, after log.sh.

# Downloads sources of Debian 12 into a folder and unpacks them. apt checks them by the signature of the
# archive. Its list and what it knows are in the folder, so those of the system stay as they are.
debian_sources() { # folder package...
    local folder site apt
    mkdir -p "$1"/{list,state/partial}
    folder=$(realpath "$1")
    shift
    # from where this system has its packages
    site=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 'Codename: bookworm' 'Origin: Debian' |
        head -n 1)
    if [[ -z $site ]]; then
        echo "$0: apt has no packages of Debian 12 (bookworm), expected Debian 12" >&2
        exit 1
    fi
    printf '%s\n' "Types: deb-src" "URIs: $site" "Suites: bookworm" "Components: main" \
        "Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg" >"$folder/list/debian.sources"
    apt=(apt-get -q -oAPT::Sandbox::User=root -oDir::Etc::sourcelist=/dev/null
         -oDir::Etc::sourceparts="$folder/list" -oDir::State::lists="$folder/state")
    logged "${apt[@]}" update
    (cd "$folder" && logged "${apt[@]}" source "$@")
}
