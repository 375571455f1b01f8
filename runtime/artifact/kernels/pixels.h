// Numbers as pixels of any type.
#pragma once

#include <algorithm>
#include <limits>
#include <type_traits>

namespace chiasm::kernels {

/** The value as a pixel: for integer types without its fraction, and saturated. */
template <class P>
P as_pixel(double value) {
  if constexpr (std::is_floating_point_v<P>) return static_cast<P>(value);
  constexpr double low = std::numeric_limits<P>::lowest(), high = std::numeric_limits<P>::max();
  return static_cast<P>(value > low ? std::min(value, high) : low);
}

}  // namespace chiasm::kernels
