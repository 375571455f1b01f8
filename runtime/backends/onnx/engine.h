/** The one ONNX Runtime of the process: its library, environment and thread pool. */
#pragma once

#include <cstdint>
#include <string>

// The library is found at run time, so that the plug-in can say what is missing, and its function table is
// asked for the newest version that it and our header both have.
#define ORT_API_MANUAL_INIT
#include <onnxruntime_cxx_api.h>

namespace chiasm::onnx {

/** Opens the library at the first call, and returns its version, e.g. "1.31.1". It tries, in this order: a
 *  library that is already in the process, the path in CHIASM_ONNXRUNTIME_LIBRARY, the plug-in's run path and
 *  the system's folders. Throws base::Error(CHIASM_UNAVAILABLE), which says what to do. */
const std::string& open_engine();

/** The environment, with one thread pool and one arena that all sessions share; made with the first call's
 *  number. */
const Ort::Env& environment(int32_t num_threads);

/** Creates the threads of the pools of ThreadingOptions and SessionOptions. A fork waits until these threads
 *  sleep, because they hold locks of their pool for a moment after a run. */
OrtCustomThreadHandle begin_thread(void* options, OrtThreadWorkerFn work, void* argument) noexcept;
void join_thread(OrtCustomThreadHandle thread) noexcept;

/** Whether libchiasm_ort.so is installed with this plug-in. */
bool has_custom_op_library();
/** The path of libchiasm_ort.so, which is installed with this plug-in; throws base::Error(CHIASM_UNAVAILABLE)
 *  if it is not. */
std::string custom_op_library();

/** Whether this build of ONNX Runtime has the provider, e.g. "CUDAExecutionProvider". */
bool has_provider(const char* name);

}  // namespace chiasm::onnx
