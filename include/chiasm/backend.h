/** The interface between the core and a backend plug-in. docs/howto/backend.md writes one step by step.
 *
 *  A backend is a library `libchiasm_<name>.so` in a plug-in folder. It exports one symbol,
 *  `chiasm_backend_entry`, which returns a table. The core knows no backend by name; everything that it needs
 *  is in that table.
 *
 *  Only plain C types cross this interface, because the core and a plug-in may be built with different C++
 *  settings. A plug-in catches every exception of its engine and returns it as a chiasm_code and a text.
 *
 *  A plug-in must open without its engine (ONNX Runtime, libtorch, ...): the core opens all plug-ins to read
 *  their tables. `probe` opens the engine. It is called only when the backend is about to be used or is asked
 *  about.
 */
#ifndef CHIASM_BACKEND_H
#define CHIASM_BACKEND_H

#include "chiasm/chiasm.h"

/** The version of this interface. The core rejects a plug-in of another version with a message. */
#define CHIASM_BACKEND_ABI 5u

#ifdef __cplusplus
extern "C" {
#endif

/** Where a backend writes what went wrong; NUL-terminated, truncated to fit. */
typedef struct chiasm_error_text {
  char text[2048];
} chiasm_error_text;

/** A format of artifacts that a backend loads. */
typedef struct chiasm_backend_format {
  const char* name; /**< as the manifest names it: "onnx", "torchscript", "aotinductor" */
  /** 1: loading an artifact runs code that came with the bundle; 0: artifacts are data */
  int32_t is_program;
} chiasm_backend_format;

/** An option that a user may set when loading a method (chiasm_load_options.options). */
typedef struct chiasm_backend_option {
  const char* key;
  const char* values;      /**< what the value may be, for messages: "0 or 1" */
  const char* description; /**< one sentence */
} chiasm_backend_option;

/** The artifact to load. All pointers are valid only during the call. */
typedef struct chiasm_backend_load {
  size_t struct_size;
  const void* data; /**< the artifact's bytes, whose hash the core has checked; NULL in a call of `rank` */
  size_t size;
  /** for messages only: never open it, its content may have changed since it was hashed */
  const char* file;
  const char* format; /**< one of the backend's formats */
  int32_t device_type, device_index;
  int32_t num_threads;     /**< how many threads a run may use, always > 0 */
  int32_t process_threads; /**< the process's limit, num_threads is at most that */
  int32_t allow_programs;  /**< 0: the caller or the trust policy forbids code that came with the bundle */
  int32_t input_count, output_count;
  const char* const* input_names; /**< in the method's order */
  const char* const* output_names;
  /** The method's signature as a text. Compiled code must carry the same text. */
  const char* signature;
  /** Bit i is set if the first dimension of input (output) i counts independent samples, so that a batch may
   *  be run in parts. All 0 if samples depend on each other. */
  uint64_t batched_inputs, batched_outputs;
  const char* bundle;          /**< the bundle's folder */
  const char* manifest_sha256; /**< the hash of the manifest that the core has checked */
  /** The artifact's options in the manifest, for this backend: "key=value" texts, then NULL. */
  const char* const* artifact_options;
  /** The user's options for this backend: "key=value" texts, then NULL. The core has checked the keys. */
  const char* const* options;
} chiasm_backend_load;

typedef struct chiasm_backend {
  size_t struct_size;
  uint32_t abi;     /**< CHIASM_BACKEND_ABI */
  const char* name; /**< as in the library's file name: lower-case letters, digits and underscores */
  /** `auto` takes the backend with the highest priority that can run a method; the name breaks ties */
  int32_t priority;
  const chiasm_backend_format* formats; /**< ends with a NULL name */
  uint32_t devices;                     /**< bit CHIASM_CPU, bit CHIASM_CUDA: 1u << chiasm_device_type */
  const chiasm_backend_option* options; /**< ends with a NULL key; NULL: none */

  /** Opens the engine and fills in engine_version and has_cuda. Called once, and again if it has returned
   *  CHIASM_OUT_OF_MEMORY or CHIASM_IO_ERROR. Its error text says how to get the engine. */
  int32_t (*probe)(chiasm_backend_info* info, chiasm_error_text* error);
  /** Ranks one of the method's artifacts that fit the machine: the core takes the highest, and none below 0.
   *  May be NULL. Called before `probe`: it must not open the engine. */
  int32_t (*rank)(const chiasm_backend_load* request);
  /** If it returns CHIASM_UNAVAILABLE or CHIASM_VERSION_MISMATCH, the core tries the next artifact or
   *  backend. */
  int32_t (*load)(const chiasm_backend_load* request, void** model, chiasm_error_text* error);
  /** Reads `inputs`, writes `outputs`. The core has checked them against the manifest: dense, right shape and
   *  dtype, not overlapping. May be called from several threads at once. */
  int32_t (*run)(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                 const chiasm_run_options* options, chiasm_error_text* error);
  void (*unload)(void* model);
} chiasm_backend;

/** The type of the plug-in's one symbol. It returns NULL if the plug-in does not support this `abi`. */
typedef const chiasm_backend* (*chiasm_backend_entry_fn)(uint32_t abi);
#define CHIASM_BACKEND_ENTRY "chiasm_backend_entry"

#ifdef __cplusplus
}
#endif

#endif /* CHIASM_BACKEND_H */
