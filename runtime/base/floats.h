/** The floating-point environment that engines run in. */
#pragma once

#include <cstdint>

namespace chiasm::base {

/** While one lives, this thread rounds to nearest, keeps subnormal numbers and gets no signal for a
 *  floating-point exception, whatever the caller has set. Then the caller's environment is restored, with its
 *  flags. A thread that is created meanwhile starts with the same environment. Takes a few nanoseconds. */
class DefaultFloats final {
 public:
  DefaultFloats() noexcept : callers_(control()) { set_control(kDefault); }
  DefaultFloats(const DefaultFloats&) = delete;
  DefaultFloats& operator=(const DefaultFloats&) = delete;
  ~DefaultFloats() { set_control(callers_); }

 private:
#if defined(__x86_64__)
  using Control = uint32_t;                    // MXCSR; nothing here computes with the x87's registers
  static constexpr Control kDefault = 0x1f80;  // all exceptions are masked
  static Control control() noexcept { return __builtin_ia32_stmxcsr(); }
  static void set_control(Control value) noexcept { __builtin_ia32_ldmxcsr(value); }
#elif defined(__aarch64__)
  using Control = uint64_t;  // FPCR
  static constexpr Control kDefault = 0;
  static Control control() noexcept {
    Control value;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void set_control(Control value) noexcept { asm volatile("msr fpcr, %0" : : "r"(value)); }
#endif

  const Control callers_;
};

}  // namespace chiasm::base
