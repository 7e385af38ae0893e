# What `cpack` makes of an install: three Debian packages, one for each component of install().
#
#   altiro3d          runtime   libaltiro3D, the tools, their data, manual pages, completions
#   altiro3d-viewer   viewer    altiro3Dview, the library altiro3D::qt
#   libaltiro3d-dev   dev       headers, find_package, pkg-config
#
# scripts/make-packages.sh makes them from the preset deb, whose programs know /usr.
set(ALTIRO3D_PACKAGE_CONTACT "altiro3D authors <altiro3d@altiro3d.invalid>" CACHE STRING
    "Who answers for the packages: Name <mail>")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME altiro3d)
set(CPACK_PACKAGE_VENDOR "altiro3D")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_PACKAGE_CONTACT "${ALTIRO3D_PACKAGE_CONTACT}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_COMPONENTS_ALL runtime dev)
if(ALTIRO3D_BUILD_QT AND ALTIRO3D_BUILD_TOOLS)
  list(APPEND CPACK_COMPONENTS_ALL viewer)
endif()
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
    ${PROJECT_BINARY_DIR}/libaltiro3D ${PROJECT_BINARY_DIR}/libaltiro3D/qt)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF) # versions are stated below
set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

if(BUILD_SHARED_LIBS)
  file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
  set(CPACK_DEBIAN_VIEWER_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
endif()

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME altiro3d)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "photos and video as 3D pictures for light-field displays
Turns photos, RGB-D pictures, quilts and flat video into the Native
pictures that lenticular light-field displays (Looking Glass and kin) show
without glasses. Depth is estimated or given; everything runs offline.

This package holds the command-line tools and the library libaltiro3D.")
string(REGEX MATCH "^[0-9]+" avdevice_major "${AVDEVICE_VERSION}") # see ffmpeg.cpp
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "libavdevice${avdevice_major}")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "altiro3d-viewer, curl, python3")

set(CPACK_DEBIAN_VIEWER_PACKAGE_NAME altiro3d-viewer)
set(CPACK_DEBIAN_VIEWER_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_VIEWER_PACKAGE_DEPENDS "altiro3d ${same_version}, libqt5svg5")
set(CPACK_COMPONENT_VIEWER_DESCRIPTION
    "window that shows and makes 3D pictures for light-field displays
altiro3Dview opens photos, quilts, Natives and videos, turns the knobs of
their depth while one looks, simulates the lens of a light-field display,
and shows pictures on the display.

This package also holds altiro3D::qt, the library for Qt5 applications.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libaltiro3d-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "altiro3d ${same_version}, libopencv-dev")
if(viewer IN_LIST CPACK_COMPONENTS_ALL) # libaltiro3D_qt.so points into it
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS ", altiro3d-viewer ${same_version}")
  set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "qtbase5-dev")
endif()
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "3D pictures for light-field displays (development files)
Headers of libaltiro3D, which turns photos, depth, quilts and video into
pictures for lenticular light-field displays, with files for CMake and
pkg-config.")

# Changelog, copyright and compressed manuals go into the packages only, not into each install.
string(TIMESTAMP ALTIRO3D_PACKAGE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/changelog.in
  ${PROJECT_BINARY_DIR}/debian/changelog @ONLY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/copyright.in
  ${PROJECT_BINARY_DIR}/debian/copyright @ONLY)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/finish.cmake.in
  ${PROJECT_BINARY_DIR}/debian/finish.cmake @ONLY)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_BINARY_DIR}/debian/finish.cmake)
include(CPack)
