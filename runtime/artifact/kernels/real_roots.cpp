// Real roots of polynomials, a vector of them at once: between two neighbouring roots of its derivative a
// polynomial has at most one.
#include <algorithm>

#include "declared/real_roots.h"
#include "lanes.h"

namespace chiasm::kernels {
namespace {

constexpr Lanes<double> kTag;
using V = hn::Vec<Lanes<double>>;
using Mask = hn::Mask<Lanes<double>>;
constexpr double kNothing = 1e-15;  // negligible for positions, which are from -1 to 1

inline V all(double value) { return hn::Set(kTag, value); }
inline Mask is_negative(V v) { return hn::Lt(v, hn::Zero(kTag)); }
inline V middle(V low, V high) { return hn::Mul(all(0.5), hn::Add(low, high)); }

// The distance of a position from -1 or 1.
inline V room_at(V u) { return hn::Sub(all(1.0), hn::Abs(u)); }

// A polynomial of degree n, with the constant coefficient first.
struct Polynomial {
  const V* coefficients;
  int64_t degree;

  V operator()(V x) const {
    V value = coefficients[degree];
    for (int64_t k = degree - 1; k >= 0; --k) value = hn::Add(hn::Mul(value, x), coefficients[k]);
    return value;
  }

  // The value; `slope` becomes the derivative's value.
  V operator()(V x, V& slope) const {
    V value = coefficients[degree];
    slope = hn::Zero(kTag);
    for (int64_t k = degree - 1; k >= 0; --k) {
      slope = hn::Add(hn::Mul(slope, x), value);
      value = hn::Add(hn::Mul(value, x), coefficients[k]);
    }
    return value;
  }

  V at_place(V u) const { return (*this)(hn::Div(u, room_at(u))); }
};

// The root between the positions low and high, if the signs there differ in the lanes of `wanted`; low in
// others. Newton's steps, and bisection if a step leaves the interval or does not halve.
V root_between(const Polynomial& polynomial, V low, V high, Mask negative, Mask wanted) {
  V u = hn::IfThenElse(wanted, middle(low, high), low), last = hn::Sub(high, low);
  for (int step = 0; step < 100 && any(kTag, wanted); ++step) {
    const V room = room_at(u);
    V slope;
    const V value = polynomial(hn::Div(u, room), slope);
    const Mask after = hn::Xor(is_negative(value), negative);
    low = hn::IfThenElse(after, low, u);
    high = hn::IfThenElse(after, u, high);
    const V newton = hn::Sub(u, hn::Mul(hn::Mul(hn::Div(value, slope), room), room)),
            moved = hn::Abs(hn::Sub(newton, u));
    // A step of NaN (value and slope are 0) is not taken.
    const Mask taken =
        hn::And(hn::And(hn::Gt(newton, low), hn::Lt(newton, high)), hn::Lt(moved, hn::Mul(all(0.5), last)));
    const Mask small = hn::Or(hn::Lt(moved, all(kNothing)), hn::Lt(hn::Sub(high, low), all(kNothing)));
    wanted = hn::AndNot(hn::Or(hn::Eq(value, hn::Zero(kTag)), small), wanted);
    const V next = hn::IfThenElse(wanted, hn::IfThenElse(taken, newton, middle(low, high)), u);
    last = hn::Abs(hn::Sub(next, u));
    u = next;
  }
  return u;
}

// Solves a vector of polynomials with coefficients c: sets each root's position, and whether the root exists.
void solve(const V* c, int64_t n, V* places, Mask* exists) {
  V derivative[kMostTerms], ends[kMostTerms];
  const V end = all(1.0 - 1e-8);
  for (int64_t degree = 1; degree <= n; ++degree) {
    // The (n - degree)-th derivative.
    for (int64_t k = 0; k <= degree; ++k) {
      V factor = all(1.0);
      for (int64_t j = 1; j <= n - degree; ++j) factor = hn::Mul(factor, all(static_cast<double>(k + j)));
      derivative[k] = hn::Mul(c[k + n - degree], factor);
    }
    const Polynomial polynomial{derivative, degree};
    ends[0] = hn::Neg(end);
    for (int64_t i = 1; i < degree; ++i) ends[i] = places[i - 1];
    ends[degree] = end;
    Mask negative = is_negative(polynomial.at_place(ends[0]));
    for (int64_t i = 0; i < degree; ++i) {
      const Mask upper = is_negative(polynomial.at_place(ends[i + 1]));
      exists[i] = hn::Xor(negative, upper);
      places[i] = root_between(polynomial, ends[i], ends[i + 1], negative, exists[i]);
      negative = upper;
    }
  }
}

}  // namespace

void real_roots(const double* coefficients, int64_t terms, int64_t count, double* places) {
  const int64_t degree = terms - 1;
  double* const exist = places + degree * count;
  constexpr int64_t lanes = kLanes<double>;
#pragma omp parallel for
  for (int64_t i = 0; i < count; i += lanes) {
    V c[kMostTerms], roots[kMostTerms - 1];
    Mask exists[kMostTerms - 1];
    const int64_t left = std::min(lanes, count - i);
    double values[lanes];
    for (int64_t k = 0; k <= degree; ++k) {
      for (int64_t lane = 0; lane < lanes; ++lane)
        values[lane] = coefficients[k * count + i + std::min(lane, left - 1)];
      c[k] = hn::LoadU(kTag, values);
    }
    solve(c, degree, roots, exists);
    for (int64_t k = 0; k < degree; ++k) {
      hn::StoreU(roots[k], kTag, values);
      std::copy_n(values, left, places + k * count + i);
      hn::StoreU(hn::IfThenElseZero(exists[k], all(1.0)), kTag, values);
      std::copy_n(values, left, exist + k * count + i);
    }
  }
}

}  // namespace chiasm::kernels
