// The one symbol that libchiasm exports.
#include "core/api.h"

extern "C" const chiasm_api* chiasm_get_api(uint32_t version) { return chiasm::core::api_table(version); }
