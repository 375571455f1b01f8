# Find ONNX Runtime in a folder with include/ and lib/, as its releases have; any 1.x with C API 17 or later.
#
#   onnxruntime_ROOT            where to look first (default: .deps/onnxruntime of this project)
#   onnxruntime::onnxruntime    the imported target

set(onnxruntime_ROOT "${PROJECT_SOURCE_DIR}/.deps/onnxruntime" CACHE
  PATH "An ONNX Runtime release: a folder with include/ and lib/")

find_path(onnxruntime_INCLUDE_DIR onnxruntime_c_api.h
  HINTS "${onnxruntime_ROOT}" PATH_SUFFIXES include include/onnxruntime include/onnxruntime/core/session)
find_library(onnxruntime_LIBRARY onnxruntime HINTS "${onnxruntime_ROOT}" PATH_SUFFIXES lib lib64)

if(onnxruntime_INCLUDE_DIR)
  file(STRINGS "${onnxruntime_INCLUDE_DIR}/onnxruntime_c_api.h" api_version
    REGEX "^#define ORT_API_VERSION [0-9]+")
  string(REGEX REPLACE "[^0-9]*([0-9]+).*" "\\1" onnxruntime_API_VERSION "${api_version}")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(onnxruntime
  REQUIRED_VARS onnxruntime_LIBRARY onnxruntime_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "give a release folder with -Donnxruntime_ROOT=...")

if(onnxruntime_FOUND AND NOT TARGET onnxruntime::onnxruntime)
  add_library(onnxruntime::onnxruntime SHARED IMPORTED)
  set_target_properties(onnxruntime::onnxruntime PROPERTIES
    IMPORTED_LOCATION "${onnxruntime_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${onnxruntime_INCLUDE_DIR}")
endif()
mark_as_advanced(onnxruntime_INCLUDE_DIR onnxruntime_LIBRARY)
