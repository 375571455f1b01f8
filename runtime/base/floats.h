/** The floating-point environment that engines run in. */
#pragma once

#if defined(__x86_64__)
#include "base/floats_x86.h"
#elif defined(__aarch64__)
#include "base/floats_aarch64.h"
#endif

namespace chiasm::base {

/** While one lives, this thread rounds to nearest, keeps subnormal numbers and gets no signal for a
 *  floating-point exception, whatever the caller has set. Then the caller's environment is restored, with its
 *  flags. A thread that is created meanwhile starts with the same environment. Takes a few nanoseconds. */
class DefaultFloats final {
 public:
  DefaultFloats() noexcept : callers_(FloatControl::get()) { FloatControl::set(FloatControl::kDefault); }
  DefaultFloats(const DefaultFloats&) = delete;
  DefaultFloats& operator=(const DefaultFloats&) = delete;
  ~DefaultFloats() { FloatControl::set(callers_); }

 private:
  const FloatControl::Value callers_;
};

}  // namespace chiasm::base
