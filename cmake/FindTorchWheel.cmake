# Find libtorch inside an installed torch wheel, CPU or CUDA build, without the CUDA toolkit.
#
# torch's own package config fails for a CUDA wheel where no toolkit is installed. Nothing but the toolkit's
# headers is needed from it, and those come with the wheel. The package is located, never imported: an import
# takes seconds.
#
#   CHIASM_PYTHON_EXECUTABLE  the Python to ask
#   TorchWheel_DIR            the folder site-packages/torch; set it to skip the question
#   TorchWheel::torch         the imported target
#   TorchWheel_VERSION, TorchWheel_HAS_CUDA

if(NOT TorchWheel_DIR)
  find_program(TorchWheel_PYTHON NAMES python3 python HINTS ENV VIRTUAL_ENV PATH_SUFFIXES bin)
  set(python "${TorchWheel_PYTHON}")
  if(CHIASM_PYTHON_EXECUTABLE)
    set(python "${CHIASM_PYTHON_EXECUTABLE}")
  endif()
  if(python)
    execute_process(
      COMMAND "${python}" -c
        "from importlib.util import find_spec; s = find_spec('torch'); print(s.submodule_search_locations[0] if s else '', end='')"
      OUTPUT_VARIABLE located ERROR_QUIET RESULT_VARIABLE failed)
    if(NOT failed AND located)
      set(TorchWheel_DIR "${located}" CACHE PATH "The folder site-packages/torch" FORCE)
    endif()
  endif()
  mark_as_advanced(TorchWheel_PYTHON)
endif()

if(TorchWheel_DIR)
  find_path(TorchWheel_INCLUDE_DIR torch/script.h PATHS "${TorchWheel_DIR}/include" NO_DEFAULT_PATH)
  foreach(name c10 torch torch_cpu torch_cuda c10_cuda)
    find_library(TorchWheel_${name}_LIBRARY ${name} PATHS "${TorchWheel_DIR}/lib" NO_DEFAULT_PATH)
    mark_as_advanced(TorchWheel_${name}_LIBRARY)
  endforeach()
  if(EXISTS "${TorchWheel_DIR}/version.py")
    file(STRINGS "${TorchWheel_DIR}/version.py" line REGEX "^__version__ *=")
    string(REGEX REPLACE "[^'\"]*['\"]([^'\"]+)['\"].*" "\\1" TorchWheel_VERSION "${line}")
  endif()
  # The CUDA headers that the wheel's dependencies install: nvidia/cu13/include, or
  # nvidia/cuda_runtime/include before that.
  file(GLOB cuda_headers "${TorchWheel_DIR}/../nvidia/cu[0-9]*/include/cuda_runtime_api.h"
    "${TorchWheel_DIR}/../nvidia/cuda_runtime/include/cuda_runtime_api.h")
  if(cuda_headers)
    list(GET cuda_headers -1 cuda_header)
    get_filename_component(TorchWheel_CUDA_INCLUDE_DIR "${cuda_header}" DIRECTORY)
    get_filename_component(TorchWheel_CUDA_INCLUDE_DIR "${TorchWheel_CUDA_INCLUDE_DIR}" REALPATH)
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(TorchWheel
  REQUIRED_VARS TorchWheel_torch_LIBRARY TorchWheel_torch_cpu_LIBRARY TorchWheel_c10_LIBRARY
    TorchWheel_INCLUDE_DIR
  VERSION_VAR TorchWheel_VERSION
  REASON_FAILURE_MESSAGE "pip install torch into CHIASM_PYTHON_EXECUTABLE, or set TorchWheel_DIR")

set(TorchWheel_HAS_CUDA FALSE)
if(TorchWheel_torch_cuda_LIBRARY AND TorchWheel_c10_cuda_LIBRARY AND TorchWheel_CUDA_INCLUDE_DIR)
  set(TorchWheel_HAS_CUDA TRUE)
endif()

if(TorchWheel_FOUND AND NOT TARGET TorchWheel::torch)
  foreach(name c10 torch_cpu torch_cuda c10_cuda)
    if(TorchWheel_${name}_LIBRARY)
      add_library(TorchWheel::${name} SHARED IMPORTED)
      set_target_properties(TorchWheel::${name} PROPERTIES IMPORTED_LOCATION "${TorchWheel_${name}_LIBRARY}")
    endif()
  endforeach()
  add_library(TorchWheel::torch SHARED IMPORTED)
  set_target_properties(TorchWheel::torch PROPERTIES
    IMPORTED_LOCATION "${TorchWheel_torch_LIBRARY}"
    INTERFACE_COMPILE_DEFINITIONS "_GLIBCXX_USE_CXX11_ABI=1")
  target_include_directories(TorchWheel::torch SYSTEM INTERFACE
    "${TorchWheel_INCLUDE_DIR}" "${TorchWheel_INCLUDE_DIR}/torch/csrc/api/include")
  target_link_libraries(TorchWheel::torch INTERFACE TorchWheel::torch_cpu TorchWheel::c10)
  if(TorchWheel_HAS_CUDA)
    target_include_directories(TorchWheel::torch SYSTEM INTERFACE "${TorchWheel_CUDA_INCLUDE_DIR}")
    target_link_libraries(TorchWheel::torch INTERFACE TorchWheel::torch_cuda TorchWheel::c10_cuda)
  endif()
endif()
mark_as_advanced(TorchWheel_INCLUDE_DIR)
