#!/usr/bin/env bash
# Makes build/archive/altiro3D-VERSION-linux-MACHINE.tar.xz: one folder with the tools, the viewer and all
# libraries they need, for any Linux with glibc 2.36 or newer. Made on Debian 12, whose libraries it holds.
#
#   scripts/make-archive.sh
#
# Uses the build of scripts/make-packages.sh or scripts/quickstart.sh if it exists.
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh archive
# shellcheck source=scripts/log.sh
. scripts/log.sh
out=$PWD/build/archive
rm -rf "$out"
log_to "$out/log"
echo "Building the tools, $(minutes_here 30) if nothing is built yet"
logged cmake --preset deb
logged cmake --build --preset deb
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:.*=//p' build/package/CMakeCache.txt)
place=$(sed -n 's/^CMAKE_INSTALL_LIBDIR:.*=//p' build/package/CMakeCache.txt)
name=altiro3D-$version-linux-$(uname -m)
folder=$out/$name
for component in runtime library viewer qt; do
    logged cmake --install build/package --strip --prefix "$folder" --component "$component"
done
logged cmake --preset package # for the source tree again, as scripts/make-packages.sh
logged cmake --build --preset package
libraries=$folder/$place
plugins=$libraries/qt5/plugins

# What is loaded by name: Qt's plugins, and the libraries that ours open when they are first needed.
qt=$(qmake -query QT_INSTALL_PLUGINS)
for plugin in platforms/libq{xcb,offscreen}.so imageformats/libq{svg,jpeg}.so iconengines/libqsvgicon.so \
    platforminputcontexts/libcomposeplatforminputcontextplugin.so; do
    install -D "$qt/$plugin" "$plugins/$plugin"
    echo "$qt/$plugin" >>"$out/sources"
done
printf '%s\n' '[Paths]' 'Prefix = ..' "Plugins = $place/qt5/plugins" >"$folder/bin/qt.conf"
for library in libavdevice libavfilter; do # see ffmpeg.cpp, frame_decoder.cpp
    version_of=$(pkg-config --modversion "$library")
    file=/usr/lib/$(gcc -print-multiarch)/$library.so.${version_of%%.*}
    cp -L "$file" "$libraries/"
    echo "$file" >>"$out/sources"
done

# The libraries that all of these need. Those of the C and C++ compilers are the system's: a newer one has
# newer ones, and graphics drivers need those.
files() {
    find "$folder/bin" "$libraries" -type f -exec sh -c 'head -c 4 "$1" | grep -q ELF' _ {} \; -print
}
own='^(ld-linux.*|lib(c|m|dl|rt|pthread|resolv|util|mvec|nsl|anl|stdc\+\+|gcc_s)\.so.*)$'
files | LD_LIBRARY_PATH=$libraries xargs ldd | sed -n 's/^\t\(lib[^ ]*\) => \(\/[^ ]*\) .*/\1 \2/p' | sort -u >"$out/needed"
while read -r library file; do
    [[ ! $library =~ $own && ! -e $libraries/$library ]] || continue
    cp -L "$file" "$libraries/$library"
    echo "$file" >>"$out/sources"
done <"$out/needed"
while read -r file; do
    patchelf --set-rpath "\$ORIGIN/$(realpath --relative-to "$(dirname "$file")" "$libraries")" "$file"
done < <(files)

# Their licences. The database of packages has some of the files with /usr and some without.
licences=$folder/share/doc/licences
mkdir -p "$licences"
packages=$(sed 'p; s,^/usr,,; p; s,^,/usr,' "$out/sources" | xargs dpkg-query -S 2>/dev/null | sed 's/:.*//' | sort -u || true)
for package in $packages; do
    cp "/usr/share/doc/$package/copyright" "$licences/$package"
done

cat >"$folder/README" <<TEXT
altiro3D $version for Linux with glibc 2.36 or newer (Debian 12, Ubuntu 23.04, Fedora 37 and later ones).

    bin/photo2native PHOTO native.png     makes the picture for a lenticular display
    bin/altiro3Dview                      the window
    ./add-to-menu                         adds the window to the menu of your desktop

The folder can be moved; the tools need nothing outside of it. share/doc/altiro3d holds the documentation,
share/man the manual pages, share/doc/licences the licences of the libraries in $place.
TEXT
cat >"$folder/add-to-menu" <<'TEXT'
#!/bin/sh
# Adds altiro3Dview to the menu of this user's desktop. Run it again when the folder has moved.
set -e
here=$(cd "$(dirname "$0")" && pwd)
menu=${XDG_DATA_HOME:-$HOME/.local/share}/applications
mkdir -p "$menu"
icon=$here/share/icons/hicolor/scalable/apps/altiro3D.svg
sed "s|^Exec=altiro3Dview|Exec=\"$here/bin/altiro3Dview\"|; s|^Icon=.*|Icon=$icon|" \
    "$here/share/applications/altiro3Dview.desktop" >"$menu/altiro3Dview.desktop"
echo "added: $menu/altiro3Dview.desktop"
TEXT
chmod +x "$folder/add-to-menu"
export XZ_OPT=-6T0
tar --create --xz --sort=name --owner=0 --group=0 --mtime="@$(git log -1 --format=%ct)" \
    --file "$out/$name.tar.xz" --directory "$out" "$name"
echo "archive: $out/$name.tar.xz, $(du -m "$out/$name.tar.xz" | cut -f 1) MB"
