/** Errors inside the core are exceptions; at the C boundary each becomes a chiasm_status. */
#pragma once

#include <string>
#include <utility>

#include "base/error.h"
#include "base/floats.h"
#include "chiasm/chiasm.h"

namespace chiasm::core {

using namespace base;

/** A status for the exception that is being handled; never throws. */
chiasm_status* status_from_current_exception() noexcept;

/** Run `body` in the default floating-point environment and turn whatever it throws into a status. */
template <class Body>
chiasm_status* guarded(Body&& body) noexcept {
  const DefaultFloats floats;
  try {
    body();
    return nullptr;
  } catch (...) {
    return status_from_current_exception();
  }
}

/** An untrusted text, made fit for an error's message: one line, shortened if it is very long. */
std::string printable(std::string text);

int32_t status_code(const chiasm_status* status);
const char* status_message(const chiasm_status* status);
void status_free(chiasm_status* status);

}  // namespace chiasm::core
