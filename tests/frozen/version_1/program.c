/* A program of version 1 of the C interface, with every struct that a caller fills in. It never changes, and neither does its
 * compiled form beside it:
 *
 *     gcc -std=c11 -O1 -s -I tests/frozen program.c -o program.x86_64 -L build/release/lib -l:libchiasm.so.0
 *
 * usage: program BUNDLE      the bundle test.scale of tests/runtime/support.h: (B, 3, H, W) and (B, 2) to (B, 3, H, W) and (B, (H + 1) / 2)
 */
#include "version_1/chiasm.h"

#include <stdio.h>
#include <string.h>

static const chiasm_api* api;
static int rows;

static int failed(chiasm_status* status, const char* what) {
  if (status == NULL) return 0;
  printf("%s: %d: %s\n", what, (int)api->status_code(status), api->status_message(status));
  api->status_free(status);
  return 1;
}

static void count_row(const chiasm_self_test_row* row, void* user) {
  (void)user;
  if (row->passed != 0) ++rows;
}

int main(int argc, char** argv) {
  chiasm_load_options options = CHIASM_LOAD_OPTIONS_INIT;
  const chiasm_run_options run_options = {sizeof run_options, NULL};
  chiasm_bundle* bundle = NULL;
  chiasm_method* method = NULL;
  chiasm_outputs* outputs = NULL;
  chiasm_backend_info info;
  static float image[60], sigma[2], scaled[60], half[2];
  const int64_t image_shape[] = {1, 3, 4, 5}, pair_shape[] = {1, 2};
  int64_t shape[CHIASM_MAX_DIMS];
  int32_t ndim = 0, dtype = 0, failures = 0;
  chiasm_tensor inputs[] = {{sizeof(chiasm_tensor), image, CHIASM_FLOAT32, CHIASM_CPU, 0, 4, image_shape, NULL},
                            {sizeof(chiasm_tensor), sigma, CHIASM_FLOAT32, CHIASM_CPU, 0, 2, pair_shape, NULL}};
  chiasm_tensor results[] = {{sizeof(chiasm_tensor), scaled, CHIASM_FLOAT32, CHIASM_CPU, 0, 4, image_shape, NULL},
                             {sizeof(chiasm_tensor), half, CHIASM_FLOAT32, CHIASM_CPU, 0, 2, pair_shape, NULL}};

  for (int i = 0; i < 60; ++i) image[i] = (float)i;
  if (sizeof options != 40 || sizeof run_options != 16 || sizeof(chiasm_tensor) != 48 || sizeof info != 40) return 2;
  api = chiasm_get_api(CHIASM_API_VERSION);
  if (api == NULL || argc < 2) return 3;
  memset(&info, 0, sizeof info);
  info.struct_size = sizeof info;
  if (api->backend_count() == 0 || failed(api->backend_info(0, &info), "backend_info")) return 4;
  if (failed(api->bundle_open(argv[1], &bundle), "bundle_open")) return 5;
  options.backend = "native";
  options.warm_up = 1;
  if (failed(api->method_load(bundle, "forward", &options, &method), "method_load")) return 6;
  if (api->method_get_info(method)->input_count != 2) return 7;
  if (failed(api->method_output_shape(method, inputs, 2, 1, shape, &ndim, &dtype), "method_output_shape")) return 8;
  if (ndim != 2 || shape[1] != 2 || dtype != CHIASM_FLOAT32) return 9;
  if (failed(api->method_run(method, inputs, 2, &run_options, &outputs), "method_run")) return 10;
  if (failed(api->method_run_into(method, inputs, 2, results, 2, &run_options), "method_run_into")) return 11;
  if (memcmp(api->outputs_get(outputs, 0)->data, scaled, sizeof scaled) != 0 || scaled[59] != 118) return 12;
  options.backend = NULL;
  if (failed(api->bundle_self_test(bundle, &options, count_row, NULL, &failures), "bundle_self_test") || failures != 0) return 13;
  printf("version 1 on %s: %g, %d rows\n", api->method_backend(method), (double)scaled[59], rows);
  api->outputs_free(outputs);
  api->method_close(method);
  api->bundle_close(bundle);
  return 0;
}
