/** The floating-point environment of a thread on x86-64. */
#pragma once

#include <cstdint>

namespace chiasm::base {

/** The register MXCSR; nothing here computes with the x87's registers. */
struct FloatControl {
  using Value = uint32_t;
  static constexpr Value kDefault = 0x1f80;  // all exceptions are masked
  static Value get() noexcept { return __builtin_ia32_stmxcsr(); }
  static void set(Value value) noexcept { __builtin_ia32_ldmxcsr(value); }
};

}  // namespace chiasm::base
