// CIE L*u*v* of bytes and back: the same steps in double as in the tensor code.
#include "declared/luv_bytes.h"
#include "interleaving.h"

namespace chiasm::kernels {
namespace {

// The entries of a table of 256 numbers, indexed by bytes.
template <class D>
HWY_INLINE hn::Vec<D> entries(D d, const double* table, const uint8_t* x) {
  const hn::Rebind<uint8_t, D> bytes;
  const auto index = hn::PromoteTo(Integers<D>(), hn::LoadU(bytes, x));
  return hn::GatherIndex(d, table, hn::PromoteTo(hn::RebindToSigned<D>(), index));
}

// The nearest integer from 0 to `most`, half up; 0 for NaN.
template <class D>
HWY_INLINE hn::Vec<Integers<D>> nearest(D d, hn::Vec<D> x, double most) {
  const auto raised = hn::Add(x, hn::Set(d, 0.5));
  return truncated(d, smaller(larger(raised, hn::Zero(d)), hn::Set(d, most)));
}

template <class D>
HWY_INLINE void store_level(D d, hn::Vec<D> x, uint8_t* out) {
  const hn::Rebind<uint8_t, D> bytes;
  hn::StoreU(hn::DemoteTo(bytes, nearest(d, x, 255)), bytes, out);
}

// The sum of a row of a matrix times three numbers, in this order.
template <class D>
HWY_INLINE hn::Vec<D> mixed(D d, const double* row, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> c) {
  const auto times = [=](int k, hn::Vec<D> x) { return hn::Mul(hn::Set(d, row[k]), x); };
  return hn::Add(hn::Add(times(0, a), times(1, b)), times(2, c));
}

struct ToLuv {
  const double *light, *matrix, *curve;
  double last;  // the curve's last index
};

void luv_planes(const uint8_t* x, int64_t plane, const ToLuv& luv, int64_t n, uint8_t* out,
                int64_t out_plane) {
  const double* const m = luv.matrix;
  const auto row = [=](int k) { return m[3 * k] + m[3 * k + 1] + m[3 * k + 2]; };
  const double white = row(0) + 15 * row(1) + 3 * row(2), white_u = 4 * row(0) / white,
               white_v = 9 * row(1) / white;
  const double *const table = luv.light, *const curve = luv.curve, last = luv.last;
  for_lanes<double>(n, [=](auto d, auto, int64_t k) {
    using D = decltype(d);
    const auto whole = [=](double value) { return hn::Set(d, value); };
    hn::Vec<D> light[3], xyz[3];
    for (int c = 0; c < 3; ++c) light[c] = entries(d, table, x + c * plane + k);
    for (int c = 0; c < 3; ++c) xyz[c] = mixed(d, m + 3 * c, light[0], light[1], light[2]);
    const auto place = nearest(d, hn::Mul(xyz[1], whole(1.0 / 4194304.0)), last);
    const auto lightness = hn::GatherIndex(d, curve, hn::PromoteTo(hn::RebindToSigned<D>(), place));
    const auto sum = hn::Add(hn::Add(xyz[0], hn::Mul(whole(15), xyz[1])), hn::Mul(whole(3), xyz[2]));
    const auto weight = larger(sum, whole(1)), scale = hn::Mul(whole(13), lightness);
    const auto around = [=](double factor, hn::Vec<D> value, double of_white) {
      const auto quotient = hn::Div(hn::Mul(whole(factor), value), weight);
      return hn::Mul(scale, hn::Sub(quotient, whole(of_white)));
    };
    const auto u = around(4, xyz[0], white_u), v = around(9, xyz[1], white_v);
    uint8_t* const to = out + k;
    store_level(d, hn::Mul(lightness, whole(2.55)), to);
    store_level(d, hn::Mul(hn::Add(u, whole(134)), whole(255.0 / 354.0)), to + out_plane);
    store_level(d, hn::Mul(hn::Add(v, whole(140)), whole(255.0 / 262.0)), to + 2 * out_plane);
  });
}

struct FromLuv {
  const double *lightness, *luminance, *matrix;
  const uint8_t* curve;
  double last, eps;
};

void rgb_planes(const uint8_t* x, int64_t plane, const FromLuv& luv, int64_t n, uint8_t* out,
                int64_t out_plane) {
  alignas(kLine) int32_t places[3][kPart];
  int32_t* const first = places[0];
  for_lanes<double>(n, [=](auto d, auto, int64_t k) {
    using D = decltype(d);
    const auto whole = [=](double value) { return hn::Set(d, value); };
    const auto times = [=](double factor, hn::Vec<D> value) { return hn::Mul(whole(factor), value); };
    const auto of_byte = [=](const uint8_t* p, double step, double zero) {
      const hn::Rebind<uint8_t, D> bytes;
      const auto level = hn::PromoteTo(d, hn::PromoteTo(Integers<D>(), hn::LoadU(bytes, p + k)));
      return hn::Sub(hn::Mul(level, whole(step)), whole(zero));
    };
    const auto lightness = entries(d, luv.lightness, x + k), y = entries(d, luv.luminance, x + k);
    const auto u = of_byte(x + plane, 354.0 / 255.0, 134), v = of_byte(x + 2 * plane, 262.0 / 255.0, 140);
    const auto up = hn::Add(u, times(2.571912227675923, lightness)),
               vp = hn::Add(v, times(6.088448610215335, lightness));
    const auto ratio = hn::IfThenZeroElse(hn::Le(hn::Abs(vp), whole(luv.eps)), hn::Div(y, vp));
    const auto X = hn::Mul(times(2.25, up), ratio);
    const auto Z = hn::Sub(hn::Mul(hn::Sub(times(39, lightness), times(0.75, up)), ratio), times(5, y));
    for (int c = 0; c < 3; ++c) {
      const auto linear = mixed(d, luv.matrix + 3 * c, X, y, Z);
      const auto limited = smaller(larger(linear, hn::Zero(d)), whole(1));
      hn::StoreU(nearest(d, hn::Mul(limited, whole(16384)), luv.last), Integers<D>(), first + c * kPart + k);
    }
  });
  for (int64_t c = 0; c < 3; ++c)
    for (int64_t k = 0; k < n; ++k) out[c * out_plane + k] = luv.curve[places[c][k]];
}

}  // namespace

void luv_pixels(const uint8_t* x, int64_t n, int64_t values, const double* light, const double* matrix,
                const double* curve, int64_t places, bool interleaved, uint8_t* out) {
  const ToLuv luv{light, matrix, curve, static_cast<double>(places - 1)};
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               luv_planes(from, plane, luv, count, to, out_plane);
             });
}

void from_luv_pixels(const uint8_t* x, int64_t n, int64_t values, const double* lightness,
                     const double* luminance, const double* matrix, const uint8_t* curve, int64_t places,
                     double eps, bool interleaved, uint8_t* out) {
  const FromLuv luv{lightness, luminance, matrix, curve, static_cast<double>(places - 1), eps};
  for_planes(x, n, values / 3, 3, interleaved, out,
             [&](const uint8_t* from, int64_t plane, int64_t count, uint8_t* to, int64_t out_plane) {
               rgb_planes(from, plane, luv, count, to, out_plane);
             });
}

}  // namespace chiasm::kernels
