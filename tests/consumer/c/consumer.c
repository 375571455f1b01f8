/* The same in C11. */
#include <chiasm/chiasm.h>
#include <stdio.h>

static const chiasm_api* api;

static int failed(chiasm_status* status) {
  if (status == NULL) return 0;
  fprintf(stderr, "%d: %s\n", (int)api->status_code(status), api->status_message(status));
  api->status_free(status);
  return 1;
}

static float image[3 * 16 * 16];

int main(int argc, char** argv) {
  chiasm_bundle* bundle = NULL;
  chiasm_method* method = NULL;
  chiasm_outputs* outputs = NULL;
  const int64_t shape[] = {1, 3, 16, 16};
  chiasm_tensor input = {sizeof(chiasm_tensor), image, CHIASM_FLOAT32, CHIASM_CPU, 0, 4, shape, NULL};
  int result = 1;

  api = chiasm_get_api(CHIASM_API_VERSION);
  if (api == NULL) return 1;
  printf("chiasm %s, %d threads\n", api->library_version(), (int)api->get_num_threads());
  if (!failed(api->bundle_open("no.such.chiasm", &bundle))) return 1;
  if (argc < 2) return 0;

  if (failed(api->bundle_open(argv[1], &bundle))) return 1;
  if (!failed(api->method_load(bundle, "forward", NULL, &method)) &&
      !failed(api->method_run(method, &input, 1, NULL, &outputs))) {
    const float value = *(const float*)api->outputs_get(outputs, 0)->data;
    printf("on %s: %g\n", api->method_backend(method), (double)value);
    result = value > 0.00099f && value < 0.00101f ? 0 : 1;
  }
  api->outputs_free(outputs);
  api->bundle_close(bundle);
  api->method_close(method);
  return result;
}
