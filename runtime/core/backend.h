/** The interface between the core and a backend plug-in (`libchiasm_<name>.so`). Internal: not installed.
 *
 *  Only plain C types cross it, because the core and a plug-in may be built with different C++ settings. A plug-in exports
 *  one symbol, `chiasm_backend_entry`; it catches every exception of its engine and returns it as a chiasm_code and text.
 *  The core has validated all inputs and outputs against the manifest before it calls `run`.
 */
#ifndef CHIASM_RUNTIME_CORE_BACKEND_H
#define CHIASM_RUNTIME_CORE_BACKEND_H

#include "chiasm/chiasm.h"

#define CHIASM_BACKEND_ABI 4u

#ifdef __cplusplus
extern "C" {
#endif

/** Where a backend writes what went wrong; NUL-terminated, truncated to fit. */
typedef struct chiasm_error_text {
  char text[2048];
} chiasm_error_text;

typedef struct chiasm_backend_load {
  size_t struct_size;
  const void* data; /**< the artifact's bytes, whose hash the core has checked; valid only during the call */
  size_t size;
  const char* file;   /**< for messages only: never open it, its content may have changed since it was hashed */
  const char* format; /**< "torchscript", "onnx", "aotinductor" */
  int32_t device_type, device_index;
  int32_t num_threads; /**< the process's policy, always > 0 */
  /** torch only: run the forward and return the gradients of the inputs named below, the last inputs of the method being
   *  the gradients of the outputs. */
  int32_t autograd;
  int32_t input_count, output_count;
  const char* const* input_names; /**< in the method's order */
  const char* const* output_names;
  /** onnx only: the artifact is this one function, for which libchiasm_ort has the native code of the bundle in the folder
   *  `bundle`. NULL for a graph of standard operators. */
  const char* function;
  const char* bundle;
  /** native only: bit i is set where input (output) i begins with the dimension that counts independent samples, so that a batch
   *  may be run in parts; 0 where samples depend on each other. */
  uint64_t sample_inputs, sample_outputs;
  /** native only: the signature as the manifest has it, which must be what the code was compiled for. */
  const char* signature;
  /** With `function`: the hash of the manifest that the core has checked, which libchiasm_ort must find in `bundle` too. */
  const char* manifest_sha256;
} chiasm_backend_load;

typedef struct chiasm_backend {
  size_t struct_size;
  uint32_t abi; /**< CHIASM_BACKEND_ABI */
  const char* name;
  /** Fill engine_version and has_cuda; called once, after the plug-in was opened. */
  int32_t (*probe)(chiasm_backend_info* info, chiasm_error_text* error);
  int32_t (*load)(const chiasm_backend_load* request, void** model, chiasm_error_text* error);
  /** Reads `inputs`, writes `outputs` (dense, right shape and dtype, not overlapping). May be called concurrently. */
  int32_t (*run)(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options,
                 chiasm_error_text* error);
  void (*unload)(void* model);
} chiasm_backend;

/** The one symbol of a plug-in. NULL where it does not speak this `abi`. */
typedef const chiasm_backend* (*chiasm_backend_entry_fn)(uint32_t abi);
#define CHIASM_BACKEND_ENTRY "chiasm_backend_entry"

#ifdef __cplusplus
}
#endif

#endif /* CHIASM_RUNTIME_CORE_BACKEND_H */
