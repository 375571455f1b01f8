/** The C interface for this module: the function table, and statuses as exceptions. */
#pragma once

#include <chiasm/chiasm.h>

#include <stdexcept>
#include <string>

namespace chiasm::python {

/** Becomes chiasm.runtime.ChiasmError. */
class Error : public std::runtime_error {
 public:
  Error(chiasm_code code, const std::string& message) : std::runtime_error(message), code_(code) {}
  chiasm_code code() const noexcept { return code_; }

 private:
  chiasm_code code_;
};

inline const chiasm_api& api() {
  static const chiasm_api* const table = chiasm_get_api(CHIASM_API_VERSION);
  if (table == nullptr) throw Error(CHIASM_VERSION_MISMATCH, "libchiasm is older than this Python module");
  return *table;
}

inline void check(chiasm_status* status) {
  if (status == nullptr) return;
  const Error error(static_cast<chiasm_code>(api().status_code(status)), api().status_message(status));
  api().status_free(status);
  throw error;
}

}  // namespace chiasm::python
