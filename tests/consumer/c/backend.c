/* A backend outside of chiasm's sources, from the installed header alone. Its engine is in the plug-in. */
#include <chiasm/backend.h>
#include <stdio.h>

static int32_t failed(chiasm_error_text* error) {
  snprintf(error->text, sizeof(error->text), "this backend runs nothing");
  return CHIASM_UNAVAILABLE;
}

static int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
  (void)error;
  info->engine_version = "an engine 1.0";
  info->has_cuda = 0;
  return CHIASM_OK;
}

static int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  (void)request;
  *model = NULL;
  return failed(error);
}

static int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                   const chiasm_run_options* options, chiasm_error_text* error) {
  (void)model, (void)inputs, (void)outputs, (void)options;
  return failed(error);
}

static void unload(void* model) { (void)model; }

static const chiasm_backend_format formats[] = {{"nothing", 0}, {NULL, 0}};
static const chiasm_backend_option options[] = {{NULL, NULL, NULL}};
static const chiasm_backend backend = {sizeof(chiasm_backend),
                                       CHIASM_BACKEND_ABI,
                                       "outside",
                                       1,
                                       formats,
                                       1u << CHIASM_CPU,
                                       options,
                                       probe,
                                       NULL,
                                       load,
                                       run,
                                       unload};

const chiasm_backend* chiasm_backend_entry(uint32_t abi);
const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : NULL;
}
