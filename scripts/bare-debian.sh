# For scripts that try something on a bare Debian; to be sourced. Needs root, debootstrap and the
# network.

# Makes the Debian of that name (bookworm, trixie) in a temporary directory, $root, which goes away at
# the end.
make_root() {
    if [[ $(id -u) -ne 0 ]]; then
        echo "$0: needs root, for debootstrap and chroot" >&2
        exit 1
    fi
    root=$(mktemp -d)
    trap remove_root EXIT
    chmod 755 "$root" # apt drops to a user of its own
    echo "== a bare Debian ($1) in $root"
    debootstrap --variant=minbase "$1" "$root" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" \
        >/dev/null
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
