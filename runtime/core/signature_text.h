/** A method's signature as a text. Native code carries the same text (python/chiasm/export/formats/native.py
 *  writes it); the two must be equal. */
#pragma once

#include <string>
#include <vector>

#include "core/manifest.h"

namespace chiasm::core {

/** Names, dtypes and shapes of inputs and outputs, the limits of symbols, and which tensors are batches of
 *  independent samples; `generic_dtype` stands for T. */
std::string signature_text(const MethodSpec& method, const std::vector<Symbol>& symbols,
                           int32_t generic_dtype);

}  // namespace chiasm::core
