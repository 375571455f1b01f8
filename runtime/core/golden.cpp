// Reads elements of every type as numbers and compares them with a tolerance.
#include "core/golden.h"

#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "base/dtype.h"

namespace chiasm::core {
namespace {

template <class T>
T load(const void* data, size_t i) {
  T value;
  std::memcpy(&value, static_cast<const char*>(data) + i * sizeof(T), sizeof(T));
  return value;
}

template <class T>
double number(const void* data, size_t i) {
  return static_cast<double>(load<T>(data, i));
}

double boolean(const void* data, size_t i) { return load<uint8_t>(data, i) != 0; }

double float16(const void* data, size_t i) {
  const auto bits = load<uint16_t>(data, i);
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

double bfloat16(const void* data, size_t i) {
  const uint32_t wide = static_cast<uint32_t>(load<uint16_t>(data, i)) << 16;
  float value;
  std::memcpy(&value, &wide, sizeof value);
  return value;
}

using Element = double (*)(const void* data, size_t i);

/** How an element is read as a number, by its NumPy kind and its size. */
constexpr struct {
  char kind;
  size_t size;
  Element read;
} kElements[] = {
    {'b', 1, boolean},          {'u', 1, number<uint8_t>}, {'u', 2, number<uint16_t>},
    {'u', 4, number<uint32_t>}, {'i', 1, number<int8_t>},  {'i', 2, number<int16_t>},
    {'i', 4, number<int32_t>},  {'i', 8, number<int64_t>}, {'f', 2, float16},
    {'V', 2, bfloat16},         {'f', 4, number<float>},   {'f', 8, number<double>},
};

/** The index in kElements, or -1. */
constexpr int32_t element_of(const base::DTypeEntry& type) {
  for (int32_t i = 0; i < static_cast<int32_t>(std::size(kElements)); ++i) {
    if (kElements[i].kind == type.numpy_kind && kElements[i].size == type.size) return i;
  }
  return -1;
}

constexpr bool all_are_read() {
  for (const base::DTypeEntry& type : base::kDTypes) {
    if (element_of(type) < 0) return false;
  }
  return true;
}
static_assert(all_are_read(), "kElements has no line for a type of CHIASM_DTYPES");

}  // namespace

Comparison compare(const void* actual, const void* expected, size_t count, int32_t dtype,
                   const Tolerance& tolerance) {
  Comparison result;
  double worst_excess = 0;
  const Element element = kElements[element_of(base::kDTypes[dtype])].read;
  for (size_t i = 0; i < count; ++i) {
    const double a = element(actual, i), b = element(expected, i);
    const bool same = a == b || (std::isnan(a) && std::isnan(b));
    // Two large int64 values may differ although they are equal as doubles.
    const bool exact = dtype != CHIASM_INT64 || load<int64_t>(actual, i) == load<int64_t>(expected, i);
    if (same && exact) continue;
    double error = std::fabs(a - b);
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    if (error > result.max_error) result.max_error = error;
    const double excess = error - (tolerance.atol + tolerance.rtol * std::fabs(b));
    if (exact ? excess <= 0 : (excess <= 0 && tolerance.atol + tolerance.rtol > 0)) continue;
    ++result.mismatches;
    result.passed = false;
    // The excess is NaN if the golden value is infinite and the actual one is not; this counts as the worst.
    if (result.mismatches == 1 || (!std::isnan(worst_excess) && !(excess <= worst_excess))) {
      worst_excess = excess;
      result.worst = i;
      result.actual = a;
      result.expected = b;
    }
  }
  return result;
}

}  // namespace chiasm::core
