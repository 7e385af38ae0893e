# What `cpack` makes of an install: six Debian packages, one for each component of install().
#
#   altiro3d            runtime   the tools, their data, manual pages, completions, documents
#   altiro3d-viewer     viewer    altiro3Dview
#   libaltiro3d0.1      library   libaltiro3D
#   libaltiro3d-qt0.1   qt        the library altiro3D::qt
#   libaltiro3d-dev     dev       headers, find_package, pkg-config
#   python3-altiro3d    python    the module altiro3d
#
# The packages of the libraries carry the SONAME's number: incompatible versions are installed side by
# side. They hold nothing that two versions share, such as data.
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
if(TARGET altiro3D_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(BUILD_SHARED_LIBS)
  list(APPEND CPACK_COMPONENTS_ALL library)
  if(ALTIRO3D_BUILD_QT)
    list(APPEND CPACK_COMPONENTS_ALL qt)
  endif()
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
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=") # the SONAME tells what is compatible
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF) # versions are stated below
set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

set(library libaltiro3d${ALTIRO3D_SOVERSION})
set(qt_library libaltiro3d-qt${ALTIRO3D_SOVERSION})
if(BUILD_SHARED_LIBS)
  set(on_library ", ${library} ${same_version}")
  set(on_qt_library ", ${qt_library} ${same_version}")
  file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
  set(CPACK_DEBIAN_QT_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
endif()

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${library})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION
    "3D pictures for light-field displays (library)
libaltiro3D turns photos, depth, quilts and video into pictures for
lenticular light-field displays (Looking Glass and kin).")
string(REGEX MATCH "^[0-9]+" avdevice_major "${AVDEVICE_VERSION}") # see ffmpeg.cpp
string(REGEX MATCH "^[0-9]+" avfilter_major "${AVFILTER_VERSION}") # see frame_decoder.cpp
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS
    "libavdevice${avdevice_major}, libavfilter${avfilter_major}")
if(LIBHEIF_VERSION VERSION_GREATER_EQUAL 1.17) # its decoders are packages of their own
  string(APPEND CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS
         ", libheif-plugin-libde265, libheif-plugin-dav1d | libheif-plugin-aomdec")
endif()
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SUGGESTS "altiro3d")

set(CPACK_DEBIAN_QT_PACKAGE_NAME ${qt_library})
set(CPACK_DEBIAN_QT_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_QT_PACKAGE_DEPENDS "${library} ${same_version}")
set(CPACK_COMPONENT_QT_DESCRIPTION
    "3D pictures for light-field displays (library for Qt5)
altiro3D::qt shows pictures for lenticular light-field displays in Qt5
applications and finds these displays.")

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME altiro3d)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "photos and video as 3D pictures for light-field displays
Turns photos, RGB-D pictures, quilts and flat video into the Native
pictures that lenticular light-field displays (Looking Glass and kin) show
without glasses. Depth is estimated or given; everything runs offline.

This package holds the command-line tools.")
string(REGEX REPLACE "^, " "" CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "${on_library}")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "altiro3d-viewer, curl, python3")

set(CPACK_DEBIAN_VIEWER_PACKAGE_NAME altiro3d-viewer)
set(CPACK_DEBIAN_VIEWER_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_VIEWER_PACKAGE_DEPENDS "altiro3d ${same_version}, libqt5svg5${on_library}${on_qt_library}")
set(CPACK_DEBIAN_VIEWER_PACKAGE_RECOMMENDS "ca-certificates") # to download a depth network
set(CPACK_COMPONENT_VIEWER_DESCRIPTION
    "window that shows and makes 3D pictures for light-field displays
altiro3Dview opens photos, quilts, Natives and videos, turns the knobs of
their depth while one looks, simulates the lens of a light-field display,
and shows pictures on the display.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libaltiro3d-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libopencv-dev${on_library}")
if(ALTIRO3D_BUILD_QT)
  string(APPEND CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${on_qt_library}")
  set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS "qtbase5-dev")
endif()
set(CPACK_COMPONENT_DEV_DESCRIPTION
    "3D pictures for light-field displays (development files)
Headers of libaltiro3D, which turns photos, depth, quilts and video into
pictures for lenticular light-field displays, with files for CMake and
pkg-config.")

if(TARGET altiro3D_python)
  math(EXPR next_minor "${ALTIRO3D_PYTHON_MINOR} + 1")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-altiro3d)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${ALTIRO3D_PYTHON_MINOR}~), \
python3 (<< 3.${next_minor}), python3-numpy${on_library}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "altiro3d") # sample calibration, depth network
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
    "3D pictures for light-field displays (Python module)
The module altiro3d turns photos, depth, quilts and video into pictures for
lenticular light-field displays. Pictures are NumPy arrays, and classes of
Python can be sources of depth.")

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
