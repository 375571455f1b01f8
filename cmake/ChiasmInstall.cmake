# What an outside project finds: find_package(chiasm CONFIG) -> chiasm::chiasm, and pkg-config chiasm. Both
# are relocatable.

include(CMakePackageConfigHelpers)

set(config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/chiasm")
install(EXPORT chiasmTargets NAMESPACE chiasm:: DESTINATION "${config_dir}" COMPONENT development)
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/chiasmConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/chiasmConfig.cmake"
  INSTALL_DESTINATION "${config_dir}" NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break what came before.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/chiasmConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/chiasmConfig.cmake" "${PROJECT_BINARY_DIR}/chiasmConfigVersion.cmake"
  DESTINATION "${config_dir}" COMPONENT development)

file(RELATIVE_PATH pc_to_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
set(pc_library -lchiasm)
if(SKBUILD)
  set(pc_library "-l:libchiasm.so.${PROJECT_VERSION_MAJOR}") # libchiasm.so would be a link
endif()
configure_file("${PROJECT_SOURCE_DIR}/cmake/chiasm.pc.in" "${PROJECT_BINARY_DIR}/chiasm.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/chiasm.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT development)
