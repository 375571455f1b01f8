// Real roots of polynomials, four at once: between two neighbouring roots of its derivative a polynomial has at most one.
#include <immintrin.h>

#include <algorithm>

#include "kernels.h"

namespace chiasm::kernels {
namespace {

using V = __m256d;
using Mask = decltype(V{} < V{});
constexpr int64_t kLanes = 4;
constexpr double kNothing = 1e-15;  // of places, which go from -1 to 1

inline V absolute(V v) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), v); }
inline bool any(Mask m) { return _mm256_movemask_pd((V)m) != 0; }

// Coefficients from the constant on, of degree n.
struct Polynomial {
  const V* coefficients;
  int64_t degree;

  V operator()(V x) const {
    V value = coefficients[degree];
    for (int64_t k = degree - 1; k >= 0; --k) value = value * x + coefficients[k];
    return value;
  }

  // The value, and in `slope` the derivative's.
  V operator()(V x, V& slope) const {
    V value = coefficients[degree];
    slope = V{};
    for (int64_t k = degree - 1; k >= 0; --k) {
      slope = slope * x + value;
      value = value * x + coefficients[k];
    }
    return value;
  }
};

inline V place(V u) { return u / (1.0 - absolute(u)); }

// The root between places low and high, where the signs differ in the lanes of `wanted`; low in others. Newton's steps, and halves of the
// interval where they lead out of it or do not shrink by half.
V root_between(const Polynomial& polynomial, V low, V high, Mask negative, Mask wanted) {
  V u = wanted ? 0.5 * (low + high) : low, last = high - low;
  for (int step = 0; step < 100 && any(wanted); ++step) {
    const V room = 1.0 - absolute(u);
    V slope;
    const V value = polynomial(u / room, slope);
    const Mask before = (value < 0) == negative;
    low = before ? u : low;
    high = before ? high : u;
    const V newton = u - value / slope * room * room, moved = absolute(newton - u);
    // Not a number, where the slope is 0 too, is no step of Newton's.
    const Mask taken = (newton > low) & (newton < high) & (moved < 0.5 * last), there = (value == 0) | (moved < kNothing) | (high - low < kNothing);
    wanted &= ~there;
    const V next = wanted ? (taken ? newton : 0.5 * (low + high)) : u;
    last = absolute(next - u);
    u = next;
  }
  return u;
}

// Four polynomials: coefficients[k][lane], to places[k][lane] and whether there is a root.
void four(const V* c, int64_t n, V* places, Mask* exists) {
  V derivative[kMostDegree + 1], ends[kMostDegree + 1];
  const V end = _mm256_set1_pd(1.0 - 1e-8);
  for (int64_t degree = 1; degree <= n; ++degree) {
    // The (n - degree)-th derivative.
    for (int64_t k = 0; k <= degree; ++k) {
      V factor = _mm256_set1_pd(1.0);
      for (int64_t j = 1; j <= n - degree; ++j) factor *= _mm256_set1_pd(static_cast<double>(k + j));
      derivative[k] = c[k + n - degree] * factor;
    }
    const Polynomial polynomial{derivative, degree};
    ends[0] = -end;
    for (int64_t i = 1; i < degree; ++i) ends[i] = places[i - 1];
    ends[degree] = end;
    Mask negative = polynomial(place(ends[0])) < 0;
    for (int64_t i = 0; i < degree; ++i) {
      const Mask upper = polynomial(place(ends[i + 1])) < 0;
      exists[i] = negative != upper;
      places[i] = root_between(polynomial, ends[i], ends[i + 1], negative, exists[i]);
      negative = upper;
    }
  }
}

}  // namespace

void real_roots(const double* coefficients, int64_t degree, int64_t count, double* places, double* exist) {
#pragma omp parallel for
  for (int64_t i = 0; i < count; i += kLanes) {
    V c[kMostDegree + 1], roots[kMostDegree];
    Mask exists[kMostDegree];
    const int64_t lanes = std::min(kLanes, count - i);
    for (int64_t k = 0; k <= degree; ++k)
      for (int64_t lane = 0; lane < kLanes; ++lane) c[k][lane] = coefficients[k * count + i + std::min(lane, lanes - 1)];
    four(c, degree, roots, exists);
    for (int64_t k = 0; k < degree; ++k)
      for (int64_t lane = 0; lane < lanes; ++lane) {
        places[k * count + i + lane] = roots[k][lane];
        exist[k * count + i + lane] = exists[k][lane] ? 1 : 0;
      }
  }
}

}  // namespace chiasm::kernels
