#!/usr/bin/env bash
# Makes the Debian packages in build/package/ and holds them against lintian.
#
#   scripts/make-packages.sh [-DALTIRO3D_PACKAGE_CONTACT="NAME <MAIL>"]    who answers for them
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install-dependencies.sh package
if [[ -z ${SOURCE_DATE_EPOCH:-} ]] && when=$(git log -1 --format=%ct 2>/dev/null); then
    export SOURCE_DATE_EPOCH=$when # the same source gives the same packages
fi
umask 022
cmake --preset deb "$@"
cmake --build --preset deb
rm -f build/package/*.deb
cpack --config build/deb/CPackConfig.cmake -B build/package

# What lintian need not say:
#   initial-upload-closes-no-bugs       no bug asks for the package
#   package-name-doesnt-match-sonames   tools and library are one package: they change together
#   maintscript-calls-ldconfig          CPack's own scripts, beside the trigger
accepted=initial-upload-closes-no-bugs,package-name-doesnt-match-sonames,maintscript-calls-ldconfig
lintian --allow-root --fail-on error,warning --suppress-tags "$accepted" build/package/*.deb
echo "packages:" build/package/*.deb
