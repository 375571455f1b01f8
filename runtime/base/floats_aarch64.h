/** The floating-point environment of a thread on aarch64. */
#pragma once

#include <cstdint>

namespace chiasm::base {

/** The register FPCR. */
struct FloatControl {
  using Value = uint64_t;
  static constexpr Value kDefault = 0;
  static Value get() noexcept {
    Value value;
    asm volatile("mrs %0, fpcr" : "=r"(value));
    return value;
  }
  static void set(Value value) noexcept { asm volatile("msr fpcr, %0" : : "r"(value)); }
};

}  // namespace chiasm::base
