#include "core/cpu.h"

namespace chiasm::core {

bool cpu_supports(Isa isa) {
  if (isa == Isa::none) return true;
#if defined(__x86_64__)
  // __builtin_cpu_supports knows no name for MOVBE, LZCNT and F16C in older compilers; every CPU that has
  // AVX2, BMI2 and FMA has them.
  static const bool v3 = [] {
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2");
  }();
  static const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                         __builtin_cpu_supports("avx512vl");
  return isa == Isa::x86_64_v4 ? v4 : v3;
#else
  return false;
#endif
}

}  // namespace chiasm::core
