#include "core/golden.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "base/dtype.h"

namespace chiasm::core {
namespace {

double from_float16(uint16_t bits) {
  const int exponent = (bits >> 10) & 31;
  const int mantissa = bits & 1023;
  double value;
  if (exponent == 31) {
    value =
        mantissa == 0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  } else if (exponent == 0) {
    value = std::ldexp(mantissa, -24);
  } else {
    value = std::ldexp(mantissa + 1024, exponent - 25);
  }
  return (bits & 0x8000) != 0 ? -value : value;
}

double from_bfloat16(uint16_t bits) {
  const uint32_t wide = static_cast<uint32_t>(bits) << 16;
  float value;
  std::memcpy(&value, &wide, sizeof value);
  return value;
}

template <class T>
T load(const void* data, size_t i) {
  T value;
  std::memcpy(&value, static_cast<const char*>(data) + i * sizeof(T), sizeof(T));
  return value;
}

double element(const void* data, size_t i, int32_t dtype) {
  switch (dtype) {
    case CHIASM_BOOL: return load<uint8_t>(data, i) != 0;
    case CHIASM_UINT8: return load<uint8_t>(data, i);
    case CHIASM_INT8: return load<int8_t>(data, i);
    case CHIASM_INT16: return load<int16_t>(data, i);
    case CHIASM_INT32: return load<int32_t>(data, i);
    case CHIASM_INT64: return static_cast<double>(load<int64_t>(data, i));
    case CHIASM_UINT16: return load<uint16_t>(data, i);
    case CHIASM_FLOAT16: return from_float16(load<uint16_t>(data, i));
    case CHIASM_BFLOAT16: return from_bfloat16(load<uint16_t>(data, i));
    case CHIASM_FLOAT32: return static_cast<double>(load<float>(data, i));
    default: return load<double>(data, i);
  }
}

}  // namespace

Comparison compare(const void* actual, const void* expected, size_t count, int32_t dtype,
                   const Tolerance& tolerance) {
  Comparison result;
  double worst_excess = 0;
  for (size_t i = 0; i < count; ++i) {
    const double a = element(actual, i, dtype), b = element(expected, i, dtype);
    const bool same = a == b || (std::isnan(a) && std::isnan(b));
    // Different large int64 values may be equal as doubles.
    const bool exact = dtype != CHIASM_INT64 || load<int64_t>(actual, i) == load<int64_t>(expected, i);
    if (same && exact) continue;
    double error = std::fabs(a - b);
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    if (error > result.max_error) result.max_error = error;
    const double excess = error - (tolerance.atol + tolerance.rtol * std::fabs(b));
    if (exact ? excess <= 0 : (excess <= 0 && tolerance.atol + tolerance.rtol > 0)) continue;
    ++result.mismatches;
    result.passed = false;
    // The excess is NaN if a golden infinity came out finite, which counts as the worst.
    if (result.mismatches == 1 || !(excess <= worst_excess)) {
      worst_excess = excess;
      result.worst = i;
      result.actual = a;
      result.expected = b;
    }
  }
  return result;
}

}  // namespace chiasm::core
