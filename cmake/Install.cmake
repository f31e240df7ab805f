# What `cmake --install` puts under a prefix, and the names by which other projects link to it. Two components, which are
# the two packages: `tandem` (programs and what they read) and `development`. See docs/decisions/0031-install-and-package.md.

include(CMakePackageConfigHelpers)
set(library_folder lib)
if(CMAKE_LIBRARY_ARCHITECTURE)  # Debian's folder for an architecture: CMake looks there for packages under any prefix
  set(library_folder lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()

set(engine_libraries options base files text json realtime geometry exact voxel paging field contact dynamics scene world proximity hand_script safety haptics)
set(collab_libraries collab controller simulated simulated_hands recording trace lab)
set(dds_libraries)
if(TANDEM_BUILD_DDS)
  set(dds_libraries idl transfer dds)
endif()

# --- development: libraries, headers, CMake's files -------------------------------------------------------------------

foreach(library IN LISTS engine_libraries collab_libraries dds_libraries)
  add_library(tandem::${library} ALIAS tandem_${library})
  set_target_properties(tandem_${library} PROPERTIES EXPORT_NAME ${library})
  set(export TandemTargets)
  if(library IN_LIST dds_libraries)
    set(export TandemDdsTargets)
  endif()
  install(TARGETS tandem_${library} EXPORT ${export} ARCHIVE DESTINATION ${library_folder} COMPONENT development)
endforeach()

# The headers name one another from the top of the tree: that is include/tandem, and a user may write
# <tandem/engine/world/world.h> too.
foreach(folder engine collab)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION include/tandem COMPONENT development
    FILES_MATCHING PATTERN *.h)
endforeach()

set(cmake_files ${library_folder}/cmake/Tandem)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/TandemConfig.cmake.in
  ${PROJECT_BINARY_DIR}/package/TandemConfig.cmake INSTALL_DESTINATION ${cmake_files})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/TandemConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/TandemConfig.cmake ${PROJECT_BINARY_DIR}/package/TandemConfigVersion.cmake
  DESTINATION ${cmake_files} COMPONENT development)
install(EXPORT TandemTargets NAMESPACE tandem:: DESTINATION ${cmake_files} COMPONENT development)
if(TANDEM_BUILD_DDS)
  install(EXPORT TandemDdsTargets NAMESPACE tandem:: DESTINATION ${cmake_files} COMPONENT development)
endif()

install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/examples DESTINATION share/doc/tandem-dev COMPONENT development)

if(NOT TANDEM_BUILD_DDS)
  return()
endif()

# --- tandem: programs, and what they and their users read -------------------------------------------------------------

set(programs tandem tandem-bench tandem-device)
if(TANDEM_BUILD_VIEWER)
  list(APPEND programs tandem-view)
  install(FILES package/tandem-view.desktop DESTINATION share/applications COMPONENT tandem)
  install(FILES package/tandem.svg DESTINATION share/icons/hicolor/scalable/apps COMPONENT tandem)
endif()
install(TARGETS ${programs} RUNTIME DESTINATION bin COMPONENT tandem)

# Found from the programs, ../share/tandem/scenes (app/common/program_folders.cpp): not a folder that a user may choose.
install(DIRECTORY ${PROJECT_BINARY_DIR}/scenes/ DESTINATION share/tandem/scenes COMPONENT tandem
  FILES_MATCHING PATTERN *.json PATTERN *.stl
  PATTERN clutter* EXCLUDE  # 150 MB each, for benches; the next is for them, too
  PATTERN landing_gear* EXCLUDE
  PATTERN bracket_actuator_fixed.stl EXCLUDE
  PATTERN CMakeFiles EXCLUDE)

# Manual pages and completion, written by the programs themselves from their command lines.
set(reference ${PROJECT_BINARY_DIR}/reference)
set(write_references)
foreach(program IN LISTS programs)
  list(APPEND write_references COMMAND ${CMAKE_COMMAND} -E env USER= $<TARGET_FILE:${program}> --write-reference ${reference})
endforeach()
add_custom_command(OUTPUT ${reference}/stamp
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${reference}
  ${write_references}
  COMMAND gzip -9nr ${reference}/man1
  COMMAND ${CMAKE_COMMAND} -E touch ${reference}/stamp
  DEPENDS ${programs}
  COMMENT "Writing manual pages and completion"
  VERBATIM)
add_custom_target(reference ALL DEPENDS ${reference}/stamp)
install(DIRECTORY ${reference}/man1 DESTINATION share/man COMPONENT tandem)
install(DIRECTORY ${reference}/completions/ DESTINATION share/bash-completion/completions COMPONENT tandem)

install(FILES package/tandem-relay.service DESTINATION lib/systemd/system COMPONENT tandem)
# The documents lead to one another, so all are installed, in the places that they have here.
install(FILES NOTICE README.md CONTRIBUTING.md SECURITY.md CITATION.cff DESTINATION share/doc/tandem COMPONENT tandem)
install(DIRECTORY docs DESTINATION share/doc/tandem COMPONENT tandem PATTERN images/*.py EXCLUDE)
install(FILES LICENSE DESTINATION share/doc/tandem COMPONENT license)  # a Debian package links the system's copy instead
