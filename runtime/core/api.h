/** The function table of the C interface. */
#pragma once

#include "chiasm/chiasm.h"

namespace chiasm::core {

/** NULL if there is no such version. */
const chiasm_api* api_table(uint32_t version) noexcept;

}  // namespace chiasm::core
