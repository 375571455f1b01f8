/** The interface between the native backend and a torch-free native artifact.
 *
 *  The artifact is a shared library: AOTInductor's code for one op, linked statically with `aoti/`, which
 *  stands in for the few `aoti_torch_*` functions of libtorch that the code calls. All symbols are local but
 *  one, `chiasm_native_entry`. So nothing of libtorch, present in the process or not, can be captured by it.
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

/** What the artifact needs of the process during a run. The functions get `context`. */
typedef struct chiasm_native_host {
  void* context;
  /** scratch, aligned to 64 bytes; NULL where there is none left */
  void* (*allocate)(void* context, size_t bytes);
  void (*release)(void* context, void* data, size_t bytes);
  /** Called where num_threads is not 1. Calls body(argument, i, n) for i = 0 .. n - 1 and returns when all
   *  have returned. The host chooses n, 1 to num_threads. The n calls go on at the same time, each in its own
   *  thread: they may wait for each other. Call 0 is in this thread. */
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
  CHIASM_NATIVE_OUT_OF_MEMORY = 3 /**< `allocate` had nothing left */
};

typedef struct chiasm_native_api {
  size_t struct_size;
  uint32_t abi; /**< CHIASM_NATIVE_ABI */
  /** Tensors are dense and of the device of `host`. Each function returns a chiasm_native_result; where that
   *  is not 0 it has written a message (NUL-terminated, truncated). */
  int32_t (*create)(int32_t device_type, int32_t device_index, void** model, char* error, size_t error_size);
  int32_t (*run)(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                 const chiasm_native_host* host, char* error, size_t error_size);
  void (*destroy)(void* model);
  /** What the code was compiled for, as core::signature_text writes it: dtypes, shapes, limits of symbols.
   *  Whoever runs it compares. */
  const char* signature;
} chiasm_native_api;

typedef const chiasm_native_api* (*chiasm_native_entry_fn)(uint32_t abi);
#define CHIASM_NATIVE_ENTRY "chiasm_native_entry"

#ifdef __cplusplus
}
#endif

#endif /* CHIASM_RUNTIME_ARTIFACT_ABI_H */
