# The target `package`: Debian packages tandem and tandem-dev, by CPack. See docs/decisions/0031-install-and-package.md.

# --- what only a Debian package has -----------------------------------------------------------------------------------

set(debian ${PROJECT_BINARY_DIR}/package/debian)
configure_file(package/debian/changelog.in ${debian}/changelog @ONLY)
add_custom_command(OUTPUT ${debian}/changelog.gz ${debian}/changelog.Debian.gz
  COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/docs/changelog.md > ${debian}/changelog.gz
  COMMAND gzip -9nc ${debian}/changelog > ${debian}/changelog.Debian.gz
  DEPENDS ${PROJECT_SOURCE_DIR}/docs/changelog.md ${debian}/changelog
  VERBATIM)

# EXCLUDE_FROM_ALL: CPack installs these, `cmake --install` does not. /etc is not below the prefix.
foreach(package tandem tandem-dev)
  install(FILES package/debian/copyright ${debian}/changelog.Debian.gz ${debian}/changelog.gz
    DESTINATION share/doc/${package} COMPONENT ${package}-debian EXCLUDE_FROM_ALL)
endforeach()
file(CREATE_LINK /usr/share/common-licenses/Apache-2.0 ${debian}/LICENSE SYMBOLIC)
install(FILES ${debian}/LICENSE DESTINATION share/doc/tandem COMPONENT tandem-debian EXCLUDE_FROM_ALL)
install(FILES package/debian/tandem-relay.default DESTINATION /etc/default RENAME tandem-relay
  COMPONENT tandem-debian EXCLUDE_FROM_ALL)

# --- CPack ------------------------------------------------------------------------------------------------------------

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tandem)
set(CPACK_PACKAGE_CONTACT "Tandem developers <tandem@users.noreply.github.com>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
set(CPACK_SET_DESTDIR ON)  # for /etc
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_COMPONENTS_ALL tandem tandem-debian development tandem-dev-debian)
set(CPACK_COMPONENT_TANDEM_GROUP tandem)
set(CPACK_COMPONENT_TANDEM-DEBIAN_GROUP tandem)
set(CPACK_COMPONENT_DEVELOPMENT_GROUP development)
set(CPACK_COMPONENT_TANDEM-DEV-DEBIAN_GROUP development)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_TANDEM_PACKAGE_NAME tandem)
set(CPACK_DEBIAN_TANDEM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TANDEM_DESCRIPTION "collaborative haptics: several people hold one digital mock-up
Every site runs a peer, which simulates contact a thousand times a second by
the voxmap-pointshell method. Peers find one another on the network and need
no server. Users move an object each or hold one together; others look on.
.
This package has the program tandem, the window tandem-view and scenes.")
# linked libraries are found by dpkg-shlibdeps; these are loaded or run: security plug-ins, keys, Qt's plug-in for X11
set(CPACK_DEBIAN_TANDEM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_TANDEM_PACKAGE_DEPENDS "libddsc0debian, openssl")
set(CPACK_DEBIAN_TANDEM_PACKAGE_SUGGESTS "xvfb")
set(CPACK_DEBIAN_TANDEM_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/package/debian/conffiles
  ${PROJECT_SOURCE_DIR}/package/debian/postinst
  ${PROJECT_SOURCE_DIR}/package/debian/prerm
  ${PROJECT_SOURCE_DIR}/package/debian/postrm)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME tandem-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "collaborative haptics: libraries and headers
Static libraries of Tandem's engine (voxels, contact, dynamics) and of its
peers, with headers and CMake files: find_package(Tandem), tandem::world.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libeigen3-dev (>= 3.4), libassimp-dev, zlib1g-dev, libtbb-dev, libhwy-dev, libssl-dev (>= 3.0), libzstd-dev")  # what TandemConfig.cmake finds
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "cyclonedds-dev (>= 0.10.2)")  # its component dds

# CPack's own target would build the tests first: this one builds what it packs. CPack makes its own only where its
# configuration lies at the top of the build tree.
set(CPACK_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/package/CPackConfig.cmake)
set(CPACK_SOURCE_OUTPUT_CONFIG_FILE ${PROJECT_BINARY_DIR}/package/CPackSourceConfig.cmake)
include(CPack)
set(libraries ${engine_libraries} ${collab_libraries} ${dds_libraries})
list(REMOVE_ITEM libraries options base)  # nothing to build
list(TRANSFORM libraries PREPEND tandem_)
add_custom_target(package
  COMMAND ${CMAKE_CPACK_COMMAND} --config ${PROJECT_BINARY_DIR}/package/CPackConfig.cmake
  DEPENDS ${debian}/changelog.gz ${debian}/changelog.Debian.gz
  WORKING_DIRECTORY ${PROJECT_BINARY_DIR}
  COMMENT "Packing"
  USES_TERMINAL
  VERBATIM)
add_dependencies(package program reference ${libraries})
