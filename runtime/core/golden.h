/** Comparing what a backend computed with the golden values. */
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/manifest.h"

namespace chiasm::core {

struct Comparison {
  bool passed = true;
  double max_error = 0;  /**< largest |a - b|; NaN equals NaN, infinities equal those of their sign */
  size_t mismatches = 0; /**< elements outside of the tolerance */
  size_t worst = 0;      /**< the element of the largest excess, if any is outside */
  double actual = 0, expected = 0; /**< the values there */
};

/** Compare `count` elements: |actual - expected| <= atol + rtol * |expected|. Neither needs to be aligned. */
Comparison compare(const void* actual, const void* expected, size_t count, int32_t dtype,
                   const Tolerance& tolerance);

}  // namespace chiasm::core
