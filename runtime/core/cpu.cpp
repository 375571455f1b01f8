// Asks the compiler's CPU checks (x86) or the kernel's AT_HWCAP (aarch64) for the features of each level.
#include "core/cpu.h"

#include <iterator>

#if defined(__aarch64__)
#include <asm/hwcap.h>
#include <sys/auxv.h>
#endif

namespace chiasm::core {

bool cpu_supports(Isa isa) {
  switch (isa) {
    case Isa::none: return true;
#if defined(__x86_64__)
    // Older compilers have no name for CMPXCHG16B and LAHF; every CPU that has SSE4.2 and POPCNT has them.
    case Isa::x86_64_v2:
      __builtin_cpu_init();
      return __builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt");
    // Nor for MOVBE, LZCNT and F16C, which every CPU that has AVX2, BMI2 and FMA has.
    case Isa::x86_64_v3:
      __builtin_cpu_init();
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
             __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    case Isa::x86_64_v4:
      return cpu_supports(Isa::x86_64_v3) && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#elif defined(__aarch64__)
    // Of the additions of Armv8.1 and 8.2, compilers use the atomics and the rounding multiplications.
    case Isa::armv8_2_a: {
      constexpr unsigned long kNeeded = HWCAP_ASIMD | HWCAP_ATOMICS | HWCAP_ASIMDRDM;
      return (getauxval(AT_HWCAP) & kNeeded) == kNeeded;
    }
#endif
    default: return false;
  }
}

std::vector<Isa> supported_isas() {
  std::vector<Isa> found;
  for (size_t i = 1; i <= std::size(kIsaNames); ++i) {
    if (cpu_supports(static_cast<Isa>(i))) found.push_back(static_cast<Isa>(i));
  }
  return found;
}

bool has(Isa cpu, Isa code) {
  const auto is_x86 = [](Isa isa) { return isa >= Isa::x86_64_v2 && isa <= Isa::x86_64_v4; };
  return code == Isa::none || code == cpu || (is_x86(code) && is_x86(cpu) && code < cpu);
}

}  // namespace chiasm::core
