/** \file
 *  chiasm: the C interface of the runtime. Compiles as C11 and as C++17.
 *
 *  A *bundle* is a folder `NAME.chiasm/` that holds one op or pipeline: a manifest, the artifacts that the
 *  backends load, and golden vectors. A *method* (`forward`, `vjp`) is an entry point of a bundle. A
 *  *backend* runs an artifact of a method. chiasm has `native`, `torch` and `onnx`; any library
 *  `libchiasm_<name>.so` in a plug-in folder is one more.
 *
 *  Everything goes through one append-only table of functions, `chiasm_api`. Ask for it once:
 *
 *      const chiasm_api* api = chiasm_get_api(CHIASM_API_VERSION);
 *
 *  and check for NULL (the library is older than this header). Members are never removed, reordered or
 *  changed; new ones are appended and marked with the version that added them.
 *
 *  Errors: a function that can fail returns a `chiasm_status*`. NULL means success. Any other status holds a
 *  code and a message, which names the argument, the expected and the actual value; free it with
 *  `status_free`. No function throws.
 *
 *  Every struct begins with its size, so that the program or the library may be the newer one: set
 *  `struct_size` to sizeof in every struct that you pass. Step through an array of structs that the library
 *  returns by the `struct_size` of its first element, not by sizeof, because a newer library may have
 *  appended members.
 *
 *  Ownership: a `chiasm_method` keeps its bundle and backend alive, so handles may be closed in any order.
 *  Strings and info structs returned by a handle live as long as that handle.
 *
 *  Threads: every function may be called from any thread. One method may run in many threads at once. Closing
 *  a handle while another thread uses that same handle is undefined behaviour.
 *
 *  Stack: a call to the native backend, and a load, need at most 256 KiB of the calling thread's stack. The
 *  engines of the other backends are made for the 8 MiB that threads have by default.
 *
 *  Floating point: every function that can fail sets the default environment (rounding to nearest, with
 *  subnormal numbers, no traps) in all its threads, and restores the caller's environment and flags before it
 *  returns: a result does not depend on them. Threads that another part of the program has made in an engine
 *  keep theirs.
 */
#ifndef CHIASM_CHIASM_H
#define CHIASM_CHIASM_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define CHIASM_EXPORT
#else
#define CHIASM_EXPORT __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** The version of the function table that this header describes. */
#define CHIASM_API_VERSION 4u

/** Upper limit on the number of dimensions of a tensor. */
#define CHIASM_MAX_DIMS 8

/** What went wrong; the message says it in words. Codes are grouped by who can repair it. */
typedef enum chiasm_code {
  CHIASM_OK = 0,
  /* the call */
  /** NULL, out of range, unknown name, wrong dtype, rank, shape, strides or device */
  CHIASM_INVALID_ARGUMENT = 1,
  /** right call, wrong moment (thread policy after the first load, native code not allowed) */
  CHIASM_FAILED_PRECONDITION = 2,
  /* the bundle */
  CHIASM_NOT_FOUND = 16,        /**< no such file, method, or artifact for this machine */
  CHIASM_CORRUPT = 17,          /**< truncated, tampered with, or not a bundle; the message names the file */
  CHIASM_VERSION_MISMATCH = 18, /**< written by a newer schema, or for another interface version */
  /** since 2: rejected by the trust policy: not signed, or not by a trusted key */
  CHIASM_UNTRUSTED = 19,
  /* the machine */
  /** a backend, engine library or device is missing; the message says how to get it */
  CHIASM_UNAVAILABLE = 32,
  /** since 2: the message says how many bytes were requested, if known */
  CHIASM_OUT_OF_MEMORY = 33,
  /** since 2: the system refused a file: no permission, too many open files, a failing disk */
  CHIASM_IO_ERROR = 34,
  /* the engine, or chiasm itself */
  CHIASM_INTERNAL = 48
} chiasm_code;

/** Which bundles this process runs. Values are stable. */
typedef enum chiasm_trust_policy {
  CHIASM_TRUST_ANY = 0,    /**< the default */
  CHIASM_TRUST_SIGNED = 1, /**< those that a trusted key has signed (`chiasm sign`, docs/signing.md) */
  /** any, but only artifacts that are data (ONNX, or what a backend declares as data): never a program */
  CHIASM_TRUST_DATA_ONLY = 2
} chiasm_trust_policy;

/** Element types. Values are stable. */
typedef enum chiasm_dtype {
  CHIASM_BOOL = 0, /**< a byte that is 0 or 1; on the CPU a run refuses any other */
  CHIASM_UINT8 = 1,
  CHIASM_INT8 = 2,
  CHIASM_INT16 = 3,
  CHIASM_INT32 = 4,
  CHIASM_INT64 = 5,
  CHIASM_FLOAT16 = 6,
  CHIASM_BFLOAT16 = 7,
  CHIASM_FLOAT32 = 8,
  CHIASM_FLOAT64 = 9,
  CHIASM_UINT16 = 10 /**< since 3 */
} chiasm_dtype;

/** Where memory lives. Values are stable. */
typedef enum chiasm_device_type { CHIASM_CPU = 0, CHIASM_CUDA = 1 } chiasm_device_type;

/** A non-owning view of a tensor.
 *
 *  `data` is aligned to the size of one element, and is not NULL, even if a dimension is 0. `strides` counts
 *  elements, not bytes; NULL means dense row-major. A dimension of size 1 may have any stride.
 *
 *  On the CPU, elements in row-major order may have gaps between them: a region of a larger image, rows that
 *  a camera pads, the first three channels of four. Engines read dense memory, so a run copies such inputs at
 *  its start and such outputs at its end. (On CUDA, memory must be dense.) Any other strides (transposed,
 *  repeated, backwards) are rejected with a message, never misread.
 */
typedef struct chiasm_tensor {
  size_t struct_size; /**< sizeof(chiasm_tensor) */
  void* data;
  int32_t dtype;        /**< a chiasm_dtype */
  int32_t device_type;  /**< a chiasm_device_type */
  int32_t device_index; /**< 0 for the CPU */
  int32_t ndim;         /**< 0 .. CHIASM_MAX_DIMS */
  const int64_t* shape;
  const int64_t* strides;
} chiasm_tensor;

/** One dimension in a method's signature: a constant (`min == max`), or a symbol with its limits, or an
 *  expression over symbols (`"2*H"`, with min and max 0). Each symbol of a method is a whole dimension of one
 *  of its inputs. */
typedef struct chiasm_dim_info {
  size_t struct_size;
  const char* expression; /**< "3", "H", "H//2 + 1" */
  int64_t min, max;
} chiasm_dim_info;

/** One input or output in a method's signature. */
typedef struct chiasm_tensor_info {
  size_t struct_size;
  const char* name;
  const char* description;
  const char* layout;    /**< "NCHW", "HWC", ... or "". For "NHWC", (B, H, W, C), run also accepts a single
                              frame, (H, W, C), or (H, W) if it has one channel; outputs then lack the same
                              dimensions */
  const char* color;     /**< "RGB", "BGR", "GRAY", "HSV" or "" */
  const int32_t* dtypes; /**< the dtypes accepted, each a chiasm_dtype */
  /** more than one: the method is generic, and all generic tensors of a call agree */
  int32_t dtype_count;
  int32_t ndim;
  const chiasm_dim_info* dims;
  double value_min, value_max; /**< nominal range of the values; both 0 if not stated; not checked */
} chiasm_tensor_info;

/** A method's signature, known without loading any engine. */
typedef struct chiasm_method_info {
  size_t struct_size;
  const char* name;
  int32_t input_count, output_count;
  const chiasm_tensor_info* inputs;
  const chiasm_tensor_info* outputs;
} chiasm_method_info;

/** A bundle's description of itself, known without loading any engine. */
typedef struct chiasm_bundle_info {
  size_t struct_size;
  const char* name;    /**< e.g. "filters.sobel" */
  const char* version; /**< the op's semantic version */
  const char* summary;
  const char* path;
  int32_t method_count;
  const chiasm_method_info* methods;
  const char* manifest; /**< the manifest's JSON text, whole */
} chiasm_bundle_info;

/** Whether a backend can be used in this process, and if not, why and what to do. */
typedef struct chiasm_backend_info {
  size_t struct_size;
  const char* name;
  int32_t available;          /**< 1 or 0 */
  int32_t has_cuda;           /**< 1 if the engine can use a CUDA device that is present */
  const char* engine_version; /**< e.g. "onnxruntime 1.31.1"; "" if not available */
  const char* problem;        /**< "" if available; else what is missing and how to get it */
} chiasm_backend_info;

/** How to load a method. Start from CHIASM_LOAD_OPTIONS_INIT. NULL means the same. */
typedef struct chiasm_load_options {
  size_t struct_size;
  /** "native", "torch", "onnx", ...; NULL or "auto": the first, by priority, that can run it here */
  const char* backend;
  int32_t device_type; /**< CHIASM_CPU (the default) or CHIASM_CUDA */
  int32_t device_index;
  /** The native and torch artifacts are programs: loading one runs code that came with the bundle. The
   *  manifest's hash protects against damage, not against an author whom you do not trust. 1 (what
   *  CHIASM_LOAD_OPTIONS_INIT sets, because a bundle is normally shipped with the product that opens it)
   *  allows programs; 0 rejects them and leaves the artifacts that are data (ONNX in standard operators, or
   *  what a backend declares as data). */
  int32_t allow_native_code;
  /** for generic methods: load the artifact for this chiasm_dtype; -1: float32, else the first available.
   *  (Zero is CHIASM_BOOL, so start from CHIASM_LOAD_OPTIONS_INIT.) */
  int32_t dtype;
  /** 1: run once on the smallest valid input, so that the first real run is not the slow one */
  int32_t warm_up;
  /** onnx on the CPU: 1 (the default) runs the method's native code as one node inside ONNX Runtime, if the
   *  bundle has both forms and libchiasm_ort is installed. If `fused` or allow_native_code is 0, ONNX Runtime
   *  runs the graph of standard operators. */
  int32_t fused;
  /** Since 3: how many threads a run of this method may use, on every backend; 0 (the default): as many as
   *  the process may use (set_num_threads), which is also the upper limit. A server that runs several methods
   *  at once gives each 1: a run then wakes no thread and waits for none. */
  int32_t num_threads;
  /** Since 3: options of the backend named above: "key=value" texts, then NULL. NULL: no options. A key that
   *  is given twice is rejected, and so is an unknown one, with a message that lists the backend's keys. */
  const char* const* options;
} chiasm_load_options;

#define CHIASM_LOAD_OPTIONS_INIT \
  { sizeof(chiasm_load_options), NULL, CHIASM_CPU, 0, 1, -1, 0, 1, 0, NULL }

/** How to run a method. NULL means the defaults. */
typedef struct chiasm_run_options {
  size_t struct_size;
  /** CUDA: the `cudaStream_t` to enqueue on; NULL is the default stream. The call returns when the work is
   *  enqueued; inputs and outputs must stay valid until the stream reaches it. Ignored on the CPU. */
  void* stream;
} chiasm_run_options;

typedef struct chiasm_status chiasm_status;
typedef struct chiasm_bundle chiasm_bundle;
typedef struct chiasm_method chiasm_method;
typedef struct chiasm_outputs chiasm_outputs; /**< output tensors that the library allocated */

/** One row of a self-test: a golden case replayed on one backend. */
typedef struct chiasm_self_test_row {
  size_t struct_size;
  const char* method;
  const char* backend;
  const char* artifact;
  const char* dtype;
  int32_t passed;      /**< 1 pass, 0 fail, -1 not run (the message says why) */
  double max_error;    /**< largest absolute difference to the golden output */
  double tolerance;    /**< the absolute part of the tolerance */
  const char* message; /**< "" or what went wrong */
} chiasm_self_test_row;

/** Called once per row; the row's strings live until it returns. */
typedef void (*chiasm_self_test_callback)(const chiasm_self_test_row* row, void* user);

/** The function table. */
typedef struct chiasm_api {
  size_t struct_size;
  uint32_t version;

  /* since 1: statuses */
  int32_t (*status_code)(const chiasm_status* status); /**< CHIASM_OK for NULL */
  const char* (*status_message)(const chiasm_status* status);
  void (*status_free)(chiasm_status* status); /**< NULL is allowed */

  /* since 1: the library and its backends */
  const char* (*library_version)(void);
  /** How many backends are installed. They are numbered in the order in which "auto" tries them. */
  size_t (*backend_count)(void);
  /** Opens the backend's engine, so the first call for a backend may take as long as its engine takes to
   *  load. The strings live as long as the process. */
  chiasm_status* (*backend_info)(size_t index, chiasm_backend_info* info);
  /** The one thread policy of the process: how many threads a run may use, for every backend, 0 to 1024;
   *  0 (the default) means all cores this process may run on. Fails with FAILED_PRECONDITION after the first
   *  method was loaded. */
  chiasm_status* (*set_num_threads)(int32_t count);
  int32_t (*get_num_threads)(void); /**< always > 0 */

  /* since 1: bundles */
  chiasm_status* (*bundle_open)(const char* path, chiasm_bundle** bundle);
  void (*bundle_close)(chiasm_bundle* bundle); /**< NULL is allowed */
  const chiasm_bundle_info* (*bundle_get_info)(const chiasm_bundle* bundle);
  /** Replay the golden vectors of every method on every backend present here. `options` limits the test to
   *  one backend, dtype and device. Returns an error only if the test could not be run; `*failed` counts rows
   *  that failed. `callback` and `failed` may be NULL. */
  chiasm_status* (*bundle_self_test)(chiasm_bundle* bundle, const chiasm_load_options* options,
                                     chiasm_self_test_callback callback, void* user, int32_t* failed);

  /* since 1: methods */
  chiasm_status* (*method_load)(chiasm_bundle* bundle, const char* name, const chiasm_load_options* options,
                                chiasm_method** method);
  void (*method_close)(chiasm_method* method); /**< NULL is allowed */
  const chiasm_method_info* (*method_get_info)(const chiasm_method* method);
  const char* (*method_backend)(const chiasm_method* method);  /**< "native", "torch", "onnx", ... */
  const char* (*method_artifact)(const chiasm_method* method); /**< the file's name inside the bundle */
  /** The shape and dtype that output `index` will have for these inputs (their data is not read, but is
   *  checked as for a run). `shape` has room for CHIASM_MAX_DIMS. */
  chiasm_status* (*method_output_shape)(const chiasm_method* method, const chiasm_tensor* inputs,
                                        size_t input_count, size_t index, int64_t* shape, int32_t* ndim,
                                        int32_t* dtype);
  /** Run into tensors that the library allocates, on the CPU. A method that was loaded for CUDA returns
   *  FAILED_PRECONDITION: allocate the outputs on the device and use method_run_into. */
  chiasm_status* (*method_run)(chiasm_method* method, const chiasm_tensor* inputs, size_t input_count,
                               const chiasm_run_options* options, chiasm_outputs** outputs);
  /** Run into the caller's tensors, whose dtype, shape and device must be those of `method_output_shape` and
   *  which must not overlap the inputs or each other. Between two outputs, gaps count as their memory. An
   *  output may overlap an input if one of the two has gaps. */
  chiasm_status* (*method_run_into)(chiasm_method* method, const chiasm_tensor* inputs, size_t input_count,
                                    const chiasm_tensor* outputs, size_t output_count,
                                    const chiasm_run_options* options);

  /* since 1: outputs */
  size_t (*outputs_count)(const chiasm_outputs* outputs);
  /** NULL if out of range */
  const chiasm_tensor* (*outputs_get)(const chiasm_outputs* outputs, size_t index);
  void (*outputs_free)(chiasm_outputs* outputs); /**< NULL is allowed */

  /* since 2: trust */
  /** Set the trust policy of the process, a chiasm_trust_policy. It replaces the environment variables
   *  CHIASM_TRUST_POLICY (`any`, `signed`, `data_only`) and CHIASM_TRUSTED_KEYS (separated by colons). A key
   *  is a minisign public key, or the path of a file that holds one; SIGNED needs at least one. The policy is
   *  checked when a bundle is opened and again when a method is loaded, before any code of the bundle runs.
   *  Fails with FAILED_PRECONDITION after the first load, even if that load failed. */
  chiasm_status* (*set_trust)(int32_t policy, const char* const* keys, size_t key_count);
  /** The policy and the trusted keys, each of 56 characters; they live as long as the process. `keys` and
   *  `key_count` may be NULL. */
  chiasm_status* (*get_trust)(int32_t* policy, const char* const** keys, size_t* key_count);

  /* since 4: several runs in one call */
  /** Run on several sets of inputs, which may differ in their sizes, into the caller's tensors. `inputs`
   *  holds `runs` times `input_count` tensors, one run after the other, and `outputs` likewise. Images of
   *  different sizes become one batch if the output of each run is a part of one tensor.
   *
   *  As many runs execute at once as the process's number of threads allows: methods that were loaded with
   *  num_threads 1 gain most. On CUDA all runs are enqueued on the stream. All are checked as by
   *  method_run_into before the first begins, and the outputs of one run must not overlap the tensors of
   *  another. Gaps do not count between runs, which may write regions of one image that lie side by side; but
   *  if the rows of one tensor are closer together than those of the other, the gaps between them do count.
   *
   *  If some runs fail, the others are finished; the status is that of the first failed run, and its message
   *  begins with the run's number. */
  chiasm_status* (*method_run_each)(chiasm_method* method, size_t runs, const chiasm_tensor* inputs,
                                    size_t input_count, const chiasm_tensor* outputs, size_t output_count,
                                    const chiasm_run_options* options);
} chiasm_api;

/** The function table, or NULL if the library does not have this version. The table lives as long as the
 *  process. */
CHIASM_EXPORT const chiasm_api* chiasm_get_api(uint32_t version);

#ifdef __cplusplus
}
#endif

#endif /* CHIASM_CHIASM_H */
