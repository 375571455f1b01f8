/** The frozen layout of the C interface and of the plug-in interface on a 64-bit machine. A line here never
 *  changes; a new member gets a new line, and its struct a new size. */
#include <cstddef>

#include "chiasm/backend.h"
#include "chiasm/chiasm.h"

#define CHIASM_AT(type, member, offset) \
  static_assert(offsetof(type, member) == (offset), #type "::" #member " has moved")
#define CHIASM_SIZE(type, size) static_assert(sizeof(type) == (size), #type " has another size")

static_assert(sizeof(void*) == 8, "the layouts below are those of 64-bit machines");
static_assert(CHIASM_API_VERSION == 4u && CHIASM_BACKEND_ABI == 5u,
              "freeze the new version's layout here too");

CHIASM_AT(chiasm_tensor, struct_size, 0);
CHIASM_AT(chiasm_tensor, data, 8);
CHIASM_AT(chiasm_tensor, dtype, 16);
CHIASM_AT(chiasm_tensor, device_type, 20);
CHIASM_AT(chiasm_tensor, device_index, 24);
CHIASM_AT(chiasm_tensor, ndim, 28);
CHIASM_AT(chiasm_tensor, shape, 32);
CHIASM_AT(chiasm_tensor, strides, 40);
CHIASM_SIZE(chiasm_tensor, 48);

CHIASM_AT(chiasm_dim_info, struct_size, 0);
CHIASM_AT(chiasm_dim_info, expression, 8);
CHIASM_AT(chiasm_dim_info, min, 16);
CHIASM_AT(chiasm_dim_info, max, 24);
CHIASM_SIZE(chiasm_dim_info, 32);

CHIASM_AT(chiasm_tensor_info, struct_size, 0);
CHIASM_AT(chiasm_tensor_info, name, 8);
CHIASM_AT(chiasm_tensor_info, description, 16);
CHIASM_AT(chiasm_tensor_info, layout, 24);
CHIASM_AT(chiasm_tensor_info, color, 32);
CHIASM_AT(chiasm_tensor_info, dtypes, 40);
CHIASM_AT(chiasm_tensor_info, dtype_count, 48);
CHIASM_AT(chiasm_tensor_info, ndim, 52);
CHIASM_AT(chiasm_tensor_info, dims, 56);
CHIASM_AT(chiasm_tensor_info, value_min, 64);
CHIASM_AT(chiasm_tensor_info, value_max, 72);
CHIASM_SIZE(chiasm_tensor_info, 80);

CHIASM_AT(chiasm_method_info, struct_size, 0);
CHIASM_AT(chiasm_method_info, name, 8);
CHIASM_AT(chiasm_method_info, input_count, 16);
CHIASM_AT(chiasm_method_info, output_count, 20);
CHIASM_AT(chiasm_method_info, inputs, 24);
CHIASM_AT(chiasm_method_info, outputs, 32);
CHIASM_SIZE(chiasm_method_info, 40);

CHIASM_AT(chiasm_bundle_info, struct_size, 0);
CHIASM_AT(chiasm_bundle_info, name, 8);
CHIASM_AT(chiasm_bundle_info, version, 16);
CHIASM_AT(chiasm_bundle_info, summary, 24);
CHIASM_AT(chiasm_bundle_info, path, 32);
CHIASM_AT(chiasm_bundle_info, method_count, 40);
CHIASM_AT(chiasm_bundle_info, methods, 48);
CHIASM_AT(chiasm_bundle_info, manifest, 56);
CHIASM_SIZE(chiasm_bundle_info, 64);

CHIASM_AT(chiasm_backend_info, struct_size, 0);
CHIASM_AT(chiasm_backend_info, name, 8);
CHIASM_AT(chiasm_backend_info, available, 16);
CHIASM_AT(chiasm_backend_info, has_cuda, 20);
CHIASM_AT(chiasm_backend_info, engine_version, 24);
CHIASM_AT(chiasm_backend_info, problem, 32);
CHIASM_SIZE(chiasm_backend_info, 40);

CHIASM_AT(chiasm_load_options, struct_size, 0);
CHIASM_AT(chiasm_load_options, backend, 8);
CHIASM_AT(chiasm_load_options, device_type, 16);
CHIASM_AT(chiasm_load_options, device_index, 20);
CHIASM_AT(chiasm_load_options, allow_native_code, 24);
CHIASM_AT(chiasm_load_options, dtype, 28);
CHIASM_AT(chiasm_load_options, warm_up, 32);
CHIASM_AT(chiasm_load_options, fused, 36);
CHIASM_AT(chiasm_load_options, num_threads, 40);
CHIASM_AT(chiasm_load_options, options, 48);
CHIASM_SIZE(chiasm_load_options, 56);

CHIASM_AT(chiasm_run_options, struct_size, 0);
CHIASM_AT(chiasm_run_options, stream, 8);
CHIASM_SIZE(chiasm_run_options, 16);

CHIASM_AT(chiasm_self_test_row, struct_size, 0);
CHIASM_AT(chiasm_self_test_row, method, 8);
CHIASM_AT(chiasm_self_test_row, backend, 16);
CHIASM_AT(chiasm_self_test_row, artifact, 24);
CHIASM_AT(chiasm_self_test_row, dtype, 32);
CHIASM_AT(chiasm_self_test_row, passed, 40);
CHIASM_AT(chiasm_self_test_row, max_error, 48);
CHIASM_AT(chiasm_self_test_row, tolerance, 56);
CHIASM_AT(chiasm_self_test_row, message, 64);
CHIASM_SIZE(chiasm_self_test_row, 72);

CHIASM_AT(chiasm_api, struct_size, 0);
CHIASM_AT(chiasm_api, version, 8);
CHIASM_AT(chiasm_api, status_code, 16);
CHIASM_AT(chiasm_api, status_message, 24);
CHIASM_AT(chiasm_api, status_free, 32);
CHIASM_AT(chiasm_api, library_version, 40);
CHIASM_AT(chiasm_api, backend_count, 48);
CHIASM_AT(chiasm_api, backend_info, 56);
CHIASM_AT(chiasm_api, set_num_threads, 64);
CHIASM_AT(chiasm_api, get_num_threads, 72);
CHIASM_AT(chiasm_api, bundle_open, 80);
CHIASM_AT(chiasm_api, bundle_close, 88);
CHIASM_AT(chiasm_api, bundle_get_info, 96);
CHIASM_AT(chiasm_api, bundle_self_test, 104);
CHIASM_AT(chiasm_api, method_load, 112);
CHIASM_AT(chiasm_api, method_close, 120);
CHIASM_AT(chiasm_api, method_get_info, 128);
CHIASM_AT(chiasm_api, method_backend, 136);
CHIASM_AT(chiasm_api, method_artifact, 144);
CHIASM_AT(chiasm_api, method_output_shape, 152);
CHIASM_AT(chiasm_api, method_run, 160);
CHIASM_AT(chiasm_api, method_run_into, 168);
CHIASM_AT(chiasm_api, outputs_count, 176);
CHIASM_AT(chiasm_api, outputs_get, 184);
CHIASM_AT(chiasm_api, outputs_free, 192);
CHIASM_AT(chiasm_api, set_trust, 200);
CHIASM_AT(chiasm_api, get_trust, 208);
CHIASM_AT(chiasm_api, method_run_each, 216);
CHIASM_SIZE(chiasm_api, 224);

CHIASM_AT(chiasm_error_text, text, 0);
CHIASM_SIZE(chiasm_error_text, 2048);

CHIASM_AT(chiasm_backend_format, name, 0);
CHIASM_AT(chiasm_backend_format, is_program, 8);
CHIASM_SIZE(chiasm_backend_format, 16);

CHIASM_AT(chiasm_backend_option, key, 0);
CHIASM_AT(chiasm_backend_option, values, 8);
CHIASM_AT(chiasm_backend_option, description, 16);
CHIASM_SIZE(chiasm_backend_option, 24);

CHIASM_AT(chiasm_backend_load, struct_size, 0);
CHIASM_AT(chiasm_backend_load, data, 8);
CHIASM_AT(chiasm_backend_load, size, 16);
CHIASM_AT(chiasm_backend_load, file, 24);
CHIASM_AT(chiasm_backend_load, format, 32);
CHIASM_AT(chiasm_backend_load, device_type, 40);
CHIASM_AT(chiasm_backend_load, device_index, 44);
CHIASM_AT(chiasm_backend_load, num_threads, 48);
CHIASM_AT(chiasm_backend_load, process_threads, 52);
CHIASM_AT(chiasm_backend_load, allow_programs, 56);
CHIASM_AT(chiasm_backend_load, input_count, 60);
CHIASM_AT(chiasm_backend_load, output_count, 64);
CHIASM_AT(chiasm_backend_load, input_names, 72);
CHIASM_AT(chiasm_backend_load, output_names, 80);
CHIASM_AT(chiasm_backend_load, signature, 88);
CHIASM_AT(chiasm_backend_load, batched_inputs, 96);
CHIASM_AT(chiasm_backend_load, batched_outputs, 104);
CHIASM_AT(chiasm_backend_load, bundle, 112);
CHIASM_AT(chiasm_backend_load, manifest_sha256, 120);
CHIASM_AT(chiasm_backend_load, artifact_options, 128);
CHIASM_AT(chiasm_backend_load, options, 136);
CHIASM_SIZE(chiasm_backend_load, 144);

CHIASM_AT(chiasm_backend, struct_size, 0);
CHIASM_AT(chiasm_backend, abi, 8);
CHIASM_AT(chiasm_backend, name, 16);
CHIASM_AT(chiasm_backend, priority, 24);
CHIASM_AT(chiasm_backend, formats, 32);
CHIASM_AT(chiasm_backend, devices, 40);
CHIASM_AT(chiasm_backend, options, 48);
CHIASM_AT(chiasm_backend, probe, 56);
CHIASM_AT(chiasm_backend, rank, 64);
CHIASM_AT(chiasm_backend, load, 72);
CHIASM_AT(chiasm_backend, run, 80);
CHIASM_AT(chiasm_backend, unload, 88);
CHIASM_SIZE(chiasm_backend, 96);

// Values that are stored in bundles and compiled into plug-ins and programs.
static_assert(CHIASM_OK == 0 && CHIASM_INVALID_ARGUMENT == 1 && CHIASM_FAILED_PRECONDITION == 2 &&
              CHIASM_NOT_FOUND == 16 && CHIASM_CORRUPT == 17 && CHIASM_VERSION_MISMATCH == 18 &&
              CHIASM_UNAVAILABLE == 32 && CHIASM_INTERNAL == 48);
static_assert(CHIASM_UNTRUSTED == 19 && CHIASM_OUT_OF_MEMORY == 33 && CHIASM_IO_ERROR == 34 &&
              CHIASM_TRUST_ANY == 0 && CHIASM_TRUST_SIGNED == 1 && CHIASM_TRUST_DATA_ONLY == 2);
static_assert(CHIASM_BOOL == 0 && CHIASM_UINT8 == 1 && CHIASM_INT8 == 2 && CHIASM_INT16 == 3 &&
              CHIASM_INT32 == 4 && CHIASM_INT64 == 5 && CHIASM_FLOAT16 == 6 && CHIASM_BFLOAT16 == 7 &&
              CHIASM_FLOAT32 == 8 && CHIASM_FLOAT64 == 9 && CHIASM_UINT16 == 10);
static_assert(CHIASM_CPU == 0 && CHIASM_CUDA == 1 && CHIASM_MAX_DIMS == 8);
