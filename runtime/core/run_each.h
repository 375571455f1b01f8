/** Several runs of one method in one call. */
#pragma once

#include "core/method.h"

namespace chiasm::core {

/** Run `method` on `runs` sets of inputs, into as many sets of outputs, several at once. `inputs` and
 *  `outputs` hold the tensors of all runs, one run after the other. Every run is checked first. Throws Error
 *  for the first run that failed, and names it. */
void run_each(const Method& method, size_t runs, const chiasm_tensor* inputs, size_t input_count,
              const chiasm_tensor* outputs, size_t output_count, const chiasm_run_options* options);

}  // namespace chiasm::core
