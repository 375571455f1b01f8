/** Inside our libraries errors are exceptions. At a library's boundary each becomes a code and a text. */
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "chiasm/chiasm.h"

namespace chiasm::base {

/** A code and a message for the user. Any other exception counts as CHIASM_INTERNAL or
 *  CHIASM_OUT_OF_MEMORY. */
class Error : public std::exception {
 public:
  Error(chiasm_code code, std::string message) : code_(code), message_(std::move(message)) {}
  chiasm_code code() const noexcept { return code_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  chiasm_code code_;
  std::string message_;
};

[[noreturn]] inline void fail(chiasm_code code, std::string message) {
  throw Error(code, std::move(message));
}

/** Calls report(code, text) for the exception that is being handled. */
template <class Report>
auto report_current_exception(Report&& report) noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return report(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return report(CHIASM_OUT_OF_MEMORY, "out of memory");
  } catch (const std::length_error&) {  // a container was asked for more than its max_size
    return report(CHIASM_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& error) {
    return report(CHIASM_INTERNAL, error.what());
  } catch (...) {
    return report(CHIASM_INTERNAL, "something was thrown that is no std::exception");
  }
}

}  // namespace chiasm::base
