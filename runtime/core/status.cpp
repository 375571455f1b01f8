// Statuses of the C interface, made from exceptions; the one for lack of memory needs none itself.
#include "core/status.h"

#include <new>

struct chiasm_status {
  int32_t code;
  std::string message;
};

namespace chiasm::core {
namespace {

/** The one status that needs no memory: the string itself has room for its text. Never destroyed: a thread
 *  may still run at exit. */
chiasm_status* out_of_memory() noexcept {
  alignas(chiasm_status) static unsigned char memory[sizeof(chiasm_status)];
  static chiasm_status* const status = new (memory) chiasm_status{CHIASM_OUT_OF_MEMORY, "out of memory"};
  return status;
}

/** A message is one line, whatever texts of callers and engines are in it. */
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = c == '\n' || c == '\t' ? ' ' : '?';
  return text;
}

chiasm_status* make_status(int32_t code, const char* message) noexcept {
  try {
    return new chiasm_status{code, one_line(message)};
  } catch (...) {
    return out_of_memory();
  }
}

}  // namespace

chiasm_status* status_from_current_exception() noexcept {
  return report_current_exception(
      [](chiasm_code code, const char* message) { return make_status(code, message); });
}

std::string printable(std::string text) {
  constexpr size_t kLongest = 1000;
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, "...");
  return one_line(std::move(text));
}

int32_t status_code(const chiasm_status* status) { return status == nullptr ? CHIASM_OK : status->code; }

const char* status_message(const chiasm_status* status) {
  return status == nullptr ? "" : status->message.c_str();
}

void status_free(chiasm_status* status) {
  if (status != out_of_memory()) delete status;
}

}  // namespace chiasm::core
