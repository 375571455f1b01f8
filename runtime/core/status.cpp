#include "core/status.h"

#include <new>
#include <stdexcept>

struct chiasm_status {
  int32_t code;
  std::string message;
};

namespace chiasm::core {
namespace {

/** The one status that needs no memory. Made before it can be needed, never freed. */
chiasm_status* out_of_memory() noexcept {
  static chiasm_status status{CHIASM_OUT_OF_MEMORY, "out of memory"};
  return &status;
}

chiasm_status* make_status(int32_t code, const char* message) noexcept {
  try {
    return new chiasm_status{code, message};
  } catch (...) {
    return out_of_memory();
  }
}

}  // namespace

void fail(chiasm_code code, std::string message) { throw Error(code, std::move(message)); }

chiasm_status* status_from_current_exception() noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return make_status(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const std::length_error&) {  // of a container that was asked for more than there can be
    return out_of_memory();
  } catch (const std::exception& error) {
    return make_status(CHIASM_INTERNAL, error.what());
  } catch (...) {
    return make_status(CHIASM_INTERNAL, "unknown exception");
  }
}

int32_t status_code(const chiasm_status* status) { return status == nullptr ? CHIASM_OK : status->code; }

const char* status_message(const chiasm_status* status) { return status == nullptr ? "" : status->message.c_str(); }

void status_free(chiasm_status* status) {
  if (status != out_of_memory()) delete status;
}

}  // namespace chiasm::core
