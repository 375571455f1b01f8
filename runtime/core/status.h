/** Errors inside the core are exceptions; at the C border each becomes a chiasm_status. */
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "chiasm/chiasm.h"

namespace chiasm::core {

/** What the core throws: a code and a message for the user. */
class Error final : public std::exception {
 public:
  Error(chiasm_code code, std::string message) : code_(code), message_(std::move(message)) {}
  chiasm_code code() const noexcept { return code_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  chiasm_code code_;
  std::string message_;
};

[[noreturn]] void fail(chiasm_code code, std::string message);

/** A status for the exception that is being handled; never throws. */
chiasm_status* status_from_current_exception() noexcept;

/** Run `body` and turn whatever it throws into a status. */
template <class Body>
chiasm_status* guarded(Body&& body) noexcept {
  try {
    body();
    return nullptr;
  } catch (...) {
    return status_from_current_exception();
  }
}

int32_t status_code(const chiasm_status* status);
const char* status_message(const chiasm_status* status);
void status_free(chiasm_status* status);

}  // namespace chiasm::core
