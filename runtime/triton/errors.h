/** Errors at the boundary to Triton: its functions return TRITONSERVER_Error*, ours throw. */
#pragma once

#include <triton/core/tritonbackend.h>

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "chiasm/chiasm.hpp"

namespace chiasm::triton {

/** An error of this backend, or one that a function of Triton returned. */
class Failure final : public std::exception {
 public:
  Failure(TRITONSERVER_Error_Code code, std::string message) : code_(code), message_(std::move(message)) {}
  TRITONSERVER_Error_Code code() const noexcept { return code_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  TRITONSERVER_Error_Code code_;
  std::string message_;
};

[[noreturn]] inline void refuse(const std::string& message) {
  throw Failure(TRITONSERVER_ERROR_INVALID_ARG, message);
}

/** Throws what a function of Triton returned, and frees it. */
inline void check(TRITONSERVER_Error* error) {
  if (error == nullptr) return;
  Failure failure(TRITONSERVER_ErrorCode(error), TRITONSERVER_ErrorMessage(error));
  TRITONSERVER_ErrorDelete(error);
  throw failure;
}

/** Logs an error that can no longer be returned to anybody. */
inline void log_failure(TRITONSERVER_Error* error) noexcept {
  if (error == nullptr) return;
  TRITONSERVER_Error* const lost =
      TRITONSERVER_LogMessage(TRITONSERVER_LOG_ERROR, __FILE__, __LINE__, TRITONSERVER_ErrorMessage(error));
  if (lost != nullptr) TRITONSERVER_ErrorDelete(lost);
  TRITONSERVER_ErrorDelete(error);
}

/** As clients see it: HTTP turns INVALID_ARG into 400, NOT_FOUND into 404, UNAVAILABLE into 503. */
inline TRITONSERVER_Error_Code triton_code(chiasm_code code) noexcept {
  switch (code) {
    case CHIASM_INVALID_ARGUMENT:
    case CHIASM_FAILED_PRECONDITION: return TRITONSERVER_ERROR_INVALID_ARG;
    case CHIASM_NOT_FOUND: return TRITONSERVER_ERROR_NOT_FOUND;
    case CHIASM_VERSION_MISMATCH: return TRITONSERVER_ERROR_UNSUPPORTED;
    case CHIASM_UNAVAILABLE:
    case CHIASM_OUT_OF_MEMORY: return TRITONSERVER_ERROR_UNAVAILABLE;
    default: return TRITONSERVER_ERROR_INTERNAL;
  }
}

/** Runs `body`; what it throws becomes an error of Triton's. No exception passes. */
template <class Body>
TRITONSERVER_Error* guarded(Body&& body) noexcept {
  try {
    body();
    return nullptr;
  } catch (const Failure& failure) {
    return TRITONSERVER_ErrorNew(failure.code(), failure.what());
  } catch (const chiasm::Error& error) {
    return TRITONSERVER_ErrorNew(triton_code(error.code()), error.what());
  } catch (const std::bad_alloc&) {
    return TRITONSERVER_ErrorNew(TRITONSERVER_ERROR_UNAVAILABLE, "out of memory");
  } catch (const std::exception& error) {
    return TRITONSERVER_ErrorNew(TRITONSERVER_ERROR_INTERNAL, error.what());
  }
}

}  // namespace chiasm::triton
