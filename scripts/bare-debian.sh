# shellcheck shell=bash
# For scripts that try something on a bare Debian; to be sourced. Needs root, debootstrap and the
# network.

# Prints the Debian archive that apt of this machine uses, or $DEBIAN_MIRROR. apt itself reads its
# sources, in any of their formats. Only Debian's own archive has SUITE-updates next to SUITE.
debian_mirror() { # suite
    local suite mirror addresses
    if [[ -n ${DEBIAN_MIRROR:-} ]]; then
        echo "$DEBIAN_MIRROR"
        return
    fi
    addresses=$(apt-get update --print-uris)
    # shellcheck source=/dev/null
    for suite in "$1" "$(. /etc/os-release && [[ $ID != debian ]] || echo "${VERSION_CODENAME:-$1}")"; do
        mirror=$(sed -n "\|/dists/$suite-updates/InRelease'|{
            s|^'\(https\?://.*\)/dists/.*|\1|p; q }" <<<"$addresses")
        if [[ -n $mirror ]]; then
            echo "$mirror"
            return
        fi
    done
    echo "$0: apt's sources: no Debian archive with $1, expected one there or in DEBIAN_MIRROR" >&2
    return 1
}

# Makes the Debian of that name (bookworm, trixie) in a temporary directory, $root, which goes away at
# the end.
make_root() {
    if [[ $(id -u) -ne 0 ]]; then
        echo "$0: needs root, for debootstrap and chroot" >&2
        exit 1
    fi
    local mirror
    mirror=$(debian_mirror "$1")
    root=$(mktemp -d)
    trap remove_root EXIT
    chmod 755 "$root" # apt drops to a user of its own
    echo "== a bare Debian ($1) in $root"
    debootstrap --variant=minbase "$1" "$root" "$mirror" >/dev/null
    local file
    for file in /etc/resolv.conf /etc/hosts; do
        [[ ! -f $file ]] || cp -L "$file" "$root/etc/"
    done
    # apt reaches its servers as on this machine
    for file in /etc/apt/apt.conf /etc/apt/apt.conf.d/*prox*; do
        [[ ! -f $file ]] || cp "$file" "$root/etc/apt/apt.conf.d/90$(basename "$file")"
    done
}

remove_root() {
    local place
    for place in proc dev tmp; do
        ! mountpoint -q "$root/$place" || umount -R -l "$root/$place"
    done
    rm -rf --one-file-system "$root"
}

folder=/
inside() { # command: run by a shell in that Debian, in $folder
    chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive bash -euo pipefail -c "cd $folder; $1"
}
