# Find the C API of Triton Inference Server: triton::headers. A backend is linked with no library: it finds
# the server's functions in the process that opens it.
#
#   triton_INCLUDE_DIR    the folder with triton/core/tritonbackend.h (default: where tools/triton.sh puts it)

find_path(triton_INCLUDE_DIR triton/core/tritonbackend.h
  HINTS "${PROJECT_SOURCE_DIR}/.deps/triton-headers/include" /opt/tritonserver/include)
if(triton_INCLUDE_DIR)
  file(STRINGS "${triton_INCLUDE_DIR}/triton/core/tritonbackend.h" lines
    REGEX "^#define TRITONBACKEND_API_VERSION_M[AJINOR]+ [0-9]+")
  string(REGEX REPLACE "[^0-9;]" "" numbers "${lines}")
  list(JOIN numbers "." triton_VERSION)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(triton REQUIRED_VARS triton_INCLUDE_DIR VERSION_VAR triton_VERSION
  REASON_FAILURE_MESSAGE "give the folder with triton/core/tritonbackend.h: -Dtriton_INCLUDE_DIR=...")
if(triton_FOUND AND NOT TARGET triton::headers)
  add_library(triton::headers INTERFACE IMPORTED)
  target_include_directories(triton::headers SYSTEM INTERFACE "${triton_INCLUDE_DIR}")
endif()
mark_as_advanced(triton_INCLUDE_DIR)
