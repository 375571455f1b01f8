/* The C header alone, as strict C11. */
#include "chiasm/chiasm.h"

int chiasm_headers_as_c11(void);

int chiasm_headers_as_c11(void) {
  chiasm_load_options load = CHIASM_LOAD_OPTIONS_INIT;
  chiasm_run_options run = {sizeof(chiasm_run_options), NULL};
  chiasm_tensor tensor = {sizeof(chiasm_tensor), NULL, CHIASM_FLOAT32, CHIASM_CPU, 0, 0, NULL, NULL};
  const chiasm_api* api = chiasm_get_api(CHIASM_API_VERSION);
  return api != NULL && load.dtype == -1 && run.stream == NULL && tensor.ndim == 0;
}
