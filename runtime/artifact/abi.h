/** The interface between the native backend and a torch-free native artifact.
 *
 *  The artifact is a shared library: AOTInductor's code for one op, linked statically with `aoti/`, which
 *  stands in for the few `aoti_torch_*` functions of libtorch that the code calls. All symbols except
 *  `chiasm_native_entry` are local, so they cannot clash with a libtorch in the same process.
 */
#ifndef CHIASM_RUNTIME_ARTIFACT_ABI_H
#define CHIASM_RUNTIME_ARTIFACT_ABI_H

#include <stddef.h>
#include <stdint.h>

#include "chiasm/chiasm.h"

#define CHIASM_NATIVE_ABI 4u

#ifdef __cplusplus
extern "C" {
#endif

/** What the artifact needs from the process during a run. The functions get `context`. */
typedef struct chiasm_native_host {
  void* context;
  /** scratch, aligned to 64 bytes; NULL if no memory is left */
  void* (*allocate)(void* context, size_t bytes);
  void (*release)(void* context, void* data, size_t bytes);
  /** Called if num_threads is not 1. Calls body(argument, i, n) for i = 0 .. n - 1 and returns when all have
   *  returned. The host chooses n, 1 to num_threads. The n calls run at the same time, each in its own
   *  thread, so they may wait for each other. Call 0 is in this thread. */
  void (*fork)(void* context, void (*body)(void* argument, int32_t index, int32_t count), void* argument);
  int32_t device_type, device_index; /**< as chiasm_device_type */
  void* stream;                      /**< cudaStream_t, or NULL */
  int32_t num_threads;               /**< the most that `fork` will use, > 0 */
} chiasm_native_host;

enum chiasm_native_result {
  CHIASM_NATIVE_OK = 0,
  CHIASM_NATIVE_FAILED = 1,
  /** a value of an input is not allowed, such as an index that is out of range */
  CHIASM_NATIVE_BAD_VALUE = 2,
  CHIASM_NATIVE_OUT_OF_MEMORY = 3 /**< `allocate` returned NULL */
};

typedef struct chiasm_native_api {
  size_t struct_size;
  uint32_t abi; /**< CHIASM_NATIVE_ABI */
  /** Tensors are dense and of the device of `host`. Each function returns a chiasm_native_result; if that is
   *  not 0, it has written a message (NUL-terminated, truncated). */
  int32_t (*create)(int32_t device_type, int32_t device_index, void** model, char* error, size_t error_size);
  int32_t (*run)(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                 const chiasm_native_host* host, char* error, size_t error_size);
  void (*destroy)(void* model);
  /** The signature that the code was compiled for, as core::signature_text writes it: dtypes, shapes, limits
   *  of symbols. The host compares it with the manifest's. */
  const char* signature;
} chiasm_native_api;

typedef const chiasm_native_api* (*chiasm_native_entry_fn)(uint32_t abi);
#define CHIASM_NATIVE_ENTRY "chiasm_native_entry"

#ifdef __cplusplus
}
#endif

#endif /* CHIASM_RUNTIME_ARTIFACT_ABI_H */
