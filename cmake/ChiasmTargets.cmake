# How chiasm's targets are made: one place for the language, the warnings and what a library exports.

# chiasm_compile_settings(TARGET): C++17, our warnings, hidden symbols, paths that do not leak into binaries.
function(chiasm_compile_settings target)
  target_compile_features(${target} PRIVATE cxx_std_17)
  set_target_properties(${target} PROPERTIES
    C_STANDARD 11 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF
    CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -ffunction-sections -fdata-sections
    "-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=")
endfunction()

# chiasm_export_only(TARGET SYMBOL): the library exports SYMBOL and nothing else, not even what a static
# library or a template of the standard library would add; and holds nothing that this does not need.
function(chiasm_export_only target symbol)
  set(map "${CMAKE_CURRENT_BINARY_DIR}/${target}.map")
  file(CONFIGURE OUTPUT "${map}" CONTENT "{ global: ${symbol}; local: *; };\n" @ONLY)
  target_link_options(${target} PRIVATE "-Wl,--version-script=${map}" -Wl,--enable-new-dtags
    -Wl,--gc-sections)
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS "${map}")
endfunction()

# chiasm_add_backend(NAME SOURCES... [COMPONENT NAME] [NOT_INSTALLED]): the plug-in libchiasm_NAME.so (target
# chiasm_NAME), in the folder chiasm/ beside libchiasm, in the build tree as where it is installed;
# NOT_INSTALLED: in the build tree only, in a folder of its own. It must open without its engine: see
# include/chiasm/backend.h.
function(chiasm_add_backend name)
  cmake_parse_arguments(arg "NOT_INSTALLED" "COMPONENT" "" ${ARGN})
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT runtime)
  endif()
  add_library(chiasm_${name} MODULE ${arg_UNPARSED_ARGUMENTS})
  chiasm_compile_settings(chiasm_${name})
  chiasm_export_only(chiasm_${name} chiasm_backend_entry)
  target_link_libraries(chiasm_${name} PRIVATE chiasm_base)
  if(arg_NOT_INSTALLED)
    set_target_properties(chiasm_${name} PROPERTIES
      LIBRARY_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/plugins")
    return()
  endif()
  set_target_properties(chiasm_${name} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/chiasm")
  install(TARGETS chiasm_${name} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/chiasm"
    COMPONENT ${arg_COMPONENT})
endfunction()
