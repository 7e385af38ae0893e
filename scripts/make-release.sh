#!/usr/bin/env bash
# Makes all files that users download, in build/release/: Debian packages, the archive for any Linux, those for
# Windows, the page for browsers, and SHA256SUMS. Takes hours the first time.
#
#   scripts/make-release.sh
set -euo pipefail
# shellcheck source=scripts/usage.sh
. "$(dirname "$0")/usage.sh"
check_arguments 0 -- "$@"
cd "$(dirname "$0")/.."
release=$PWD/build/release
rm -rf -- "$release"
mkdir -p "$release"
scripts/make-packages.sh
scripts/make-packages.sh --arch arm64
scripts/make-archive.sh
scripts/build-windows.sh
scripts/build-web.sh
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:.*=//p' build/package/CMakeCache.txt)
cp build/package/*.deb build/package-arm64/*.deb build/archive/*.tar.xz "build/windows/altiro3D-$version-windows-x64"{.zip,-setup.exe} build/web/altiro3d-*.tgz "$release/"
cp -r build/web/page "$release/altiro3D-$version-web"
(cd "$release" && zip -qr9 "altiro3D-$version-web.zip" "altiro3D-$version-web" && rm -r "altiro3D-$version-web" &&
    sha256sum -- * >SHA256SUMS && cat SHA256SUMS)
