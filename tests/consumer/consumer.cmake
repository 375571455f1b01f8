# Run by ctest (see CMakeLists.txt). Fails at the first step that fails.

function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${ARGN}\n${output}")
  endif()
  message("${output}")
endfunction()

file(REMOVE_RECURSE "${WORK_DIR}")
set(prefix "${WORK_DIR}/prefix")
step("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${WORK_DIR}/first")
# Relocatable: the installed files work from another folder.
file(RENAME "${WORK_DIR}/first" "${prefix}")

file(GLOB plugins "${prefix}/${LIBDIR}/chiasm/libchiasm_*.so")
message("plug-ins: ${plugins}")
if(NOT plugins)
  message(FATAL_ERROR "no plug-in was installed into ${LIBDIR}/chiasm")
endif()

step("${SOURCE_DIR}/run_paths.sh" "${PROJECT_DIR}" "${prefix}")

set(flags "")
if(SANITIZE)
  set(flags "-fsanitize=${SANITIZE}")
endif()
set(bundle "")
if(WITH_BUNDLES)
  set(bundle "${BUNDLES}/filters.sobel.chiasm")
endif()

# C++17, find_package
step("${CMAKE_COMMAND}" -S "${SOURCE_DIR}/cpp" -B "${WORK_DIR}/cpp" "-DCMAKE_PREFIX_PATH=${prefix}"
  "-DCMAKE_CXX_COMPILER=${CXX_COMPILER}" "-DCMAKE_CXX_FLAGS=${flags}" -DCMAKE_BUILD_TYPE=Release)
step("${CMAKE_COMMAND}" --build "${WORK_DIR}/cpp")
step("${WORK_DIR}/cpp/consumer" ${bundle})

# An installed backend without its engine reports this and what to do; with the engine's path, it works.
function(engines expected)
  execute_process(COMMAND "${CMAKE_COMMAND}" -E env --unset=LD_LIBRARY_PATH --unset=CHIASM_ONNXRUNTIME_LIBRARY
    ${ARGN} "${WORK_DIR}/cpp/consumer"
    OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  if(NOT output MATCHES "${expected}")
    message(FATAL_ERROR "expected '${expected}' in:\n${output}")
  endif()
endfunction()
if(ONNXRUNTIME AND NOT SANITIZE)
  engines("onnx: the onnx backend is not available: [^\n]*pip install onnxruntime[^\n]*CHIASM_ONNXRUNTIME_LIBRARY")
  engines("onnx: onnxruntime 1" "CHIASM_ONNXRUNTIME_LIBRARY=${ONNXRUNTIME}")
endif()
if(LIBTORCH AND NOT SANITIZE)
  get_filename_component(libtorch_dir "${LIBTORCH}" DIRECTORY)
  engines("torch: the torch backend is not available: [^\n]*LD_LIBRARY_PATH")
  engines("torch: libtorch 2" "LD_LIBRARY_PATH=${libtorch_dir}")
endif()

# C11, pkg-config
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
set(ENV{PKG_CONFIG_PATH} "${prefix}/${LIBDIR}/pkgconfig")
execute_process(COMMAND "${PKG_CONFIG}" --cflags --libs chiasm OUTPUT_VARIABLE pc
  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${PKG_CONFIG}" --modversion chiasm OUTPUT_VARIABLE version
  COMMAND_ERROR_IS_FATAL ANY)
message("pkg-config: ${pc} ${version}")
separate_arguments(pc)
separate_arguments(flags)
step("${C_COMPILER}" -std=c11 -Wall -Wextra -pedantic -Werror ${flags} "${SOURCE_DIR}/c/consumer.c"
  -o "${WORK_DIR}/consumer_c"
  ${pc} "-Wl,-rpath,${prefix}/${LIBDIR}")
step("${WORK_DIR}/consumer_c" ${bundle})

# A backend in C11, from the installed headers
file(MAKE_DIRECTORY "${WORK_DIR}/backends")
step("${C_COMPILER}" -std=c11 -Wall -Wextra -pedantic -Werror -shared -fPIC "${SOURCE_DIR}/c/backend.c" -o
  "${WORK_DIR}/backends/libchiasm_outside.so" ${pc})
engines("outside: an engine 1.0" "CHIASM_BACKEND_PATH=${WORK_DIR}/backends")
