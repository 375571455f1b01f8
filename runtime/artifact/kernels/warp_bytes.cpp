// Reads images of bytes at positions, in planes and in frames. Positions between pixels are rounded to 1/32,
// so that weights are multiples of 1/1024, bicubic ones of 1/2^34, and sums are exact.
#include <array>
#include <cstring>
#include <type_traits>

#include "declared/warp_bytes.h"
#include "positions.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kRows = 32;
constexpr int32_t kFurthest = 1 << 24;  // in pixels: the limit of positions

// The images that are read. A pixel has `step` values, and `wide` bytes, which the taps' loaded() says, can be
// loaded at any pixel that counts as inside.
struct Source {
  int64_t height, width, step, wide;
  Padding padding;
  bool align_corners;
  int64_t row() const { return width * step; }
};

// Mirrors a position in 1/scale pixel at the corner pixels' centres or at the outer edges.
inline int32_t folded(int32_t at, int64_t size, int32_t scale, bool align_corners) {
  // in halves of 1/scale, because the edge may lie between two multiples
  const int64_t low = align_corners ? 0 : scale, period = 4 * scale * (align_corners ? size - 1 : size);
  if (period == 0) return 0;
  const int64_t turned = ((2 * int64_t{at} + low) % period + period) % period;
  const int64_t inside = (std::min(turned, period - turned) - low) / 2;
  return static_cast<int32_t>(std::clamp<int64_t>(inside, 0, scale * (size - 1)));
}

// Positions along an axis in units of 1/scale pixel, rounded half to even, limited to `least` and `greatest`;
// NaN becomes `unknown`. Runs have room for whole vectors.
inline void limited_steps(const double* x, int64_t n, int32_t scale, double least, double greatest,
                          double unknown, int32_t* out) {
  const Lanes<double> d;
  const auto low = hn::Set(d, least), high = hn::Set(d, greatest), none = hn::Set(d, unknown),
             steps = hn::Set(d, static_cast<double>(scale));
  for (int64_t i = 0; i < n; i += kLanes<double>) {
    const auto at = hn::Mul(hn::LoadU(d, x + i), steps);
    const auto limited = hn::IfThenElse(hn::Eq(at, at), smaller(larger(at, low), high), none);
    hn::StoreU(truncated(d, hn::Round(limited)), Integers<Lanes<double>>(), out + i);
  }
}

// The same, moved into the image if the padding requires it. NaN is outside.
inline void quantise(const double* x, int64_t n, int64_t size, int32_t scale, Padding padding,
                     bool align_corners, int32_t* out) {
  const double last = static_cast<double>(scale * (size - 1)), all = scale;
  const bool zeros = padding == Padding::kZeros, edge = padding == Padding::kBorder;
  const double least = zeros  ? -all
                       : edge ? 0
                              : -all * kFurthest,
               greatest = zeros  ? last + all
                          : edge ? last
                                 : all * kFurthest;
  limited_steps(x, n, scale, least, greatest, -all, out);
  if (padding != Padding::kReflection) return;
  for (int64_t i = 0; i < n; ++i)
    if (x[i] == x[i] && (out[i] < 0 || out[i] > last)) out[i] = folded(out[i], size, scale, align_corners);
}

// A run of positions: the place of the first pixel to read for each, and whether its pixels are inside.
struct Places {
  int32_t x[kRun], y[kRun], index[kRun];
  uint8_t inside[kRun];

  // The end of the stretch from i on in which all positions are inside, or all are outside.
  int64_t end(int64_t i, int64_t n) const {
    const void* const other = std::memchr(inside + i, inside[i] ? 0 : 1, static_cast<size_t>(n - i));
    return other == nullptr ? n : static_cast<const uint8_t*>(other) - inside;
  }

  // Stores a vector of pixels. Pixels are inside if their column is below `columns`, their line below
  // `lines`, and their place below `limit`.
  HWY_INLINE void put(int64_t i, hn::Vec<Lanes<int32_t>> column, hn::Vec<Lanes<int32_t>> line,
                      int64_t columns, int64_t lines, int64_t limit, const Source& s) {
    const Lanes<int32_t> d;
    const hn::Rebind<uint8_t, Lanes<int32_t>> bytes;
    const auto whole = [=](int64_t value) { return hn::Set(d, static_cast<int32_t>(value)); };
    const auto none = hn::Set(d, -1);
    const auto near = hn::And(hn::And(hn::Gt(column, none), hn::Lt(column, whole(columns))),
                              hn::And(hn::Gt(line, none), hn::Lt(line, whole(lines))));
    const auto place =
        hn::IfThenElseZero(near, hn::Add(hn::Mul(line, whole(s.row())), hn::Mul(column, whole(s.step))));
    const auto in = hn::And(near, hn::Lt(place, whole(limit)));
    hn::StoreU(place, d, index + i);
    hn::StoreU(hn::DemoteTo(bytes, hn::IfThenElseZero(in, whole(1))), bytes, inside + i);
  }

  // The offset from `index` to pixels that the next row of positions reads and this one does not.
  static int64_t ahead(const Source&) { return 0; }
};

struct Nearest : Places {
  static int64_t loaded(int64_t step) { return step == 3 ? 4 : step; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    quantise(at_x, n, s.width, 1, s.padding, s.align_corners, x);
    quantise(at_y, n, s.height, 1, s.padding, s.align_corners, y);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>) {
      const Lanes<int32_t> d;
      // inside only if that many bytes can be loaded
      put(i, hn::LoadU(d, x + i), hn::LoadU(d, y + i), s.width, s.height, s.height * s.row() - s.wide + 1, s);
    }
  }

  template <int kStep>
  void read(const uint8_t* image, const Source& s, int64_t n, uint8_t* out) const {
    const int64_t step = kStep > 0 ? kStep : s.step;
    const auto bytes = static_cast<size_t>(step);
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if (inside[i]) {
        if constexpr (kStep == 3)  // the next position overwrites the excess byte
          for (; i + 1 < last; ++i) std::memcpy(out + i * step, image + index[i], 4);
        for (; i < last; ++i) std::memcpy(out + i * step, image + index[i], bytes);
      }
      for (; i < last; ++i)
        if (x[i] >= 0 && x[i] < s.width && y[i] >= 0 && y[i] < s.height)
          std::memcpy(out + i * step, image + y[i] * s.row() + x[i] * step, bytes);
        else
          std::memset(out + i * step, 0, bytes);
    }
  }
};

constexpr int32_t kScale = 32;

struct Bilinear : Places {
  // The weights of the second pixel: across in 1/64 * 2^15, for 16-bit products, and down in 1/32; with room
  // for vectors that run over the end.
  int16_t across[kRun + 64], down[kRun + 64];

  static int64_t loaded(int64_t step) { return step == 1 ? 4 : 8; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    quantise(at_x, n, s.width, kScale, s.padding, s.align_corners, x);
    quantise(at_y, n, s.height, kScale, s.padding, s.align_corners, y);
    const Lanes<int32_t> d;
    const hn::Rebind<int16_t, Lanes<int32_t>> words;
    const auto rest = hn::Set(d, kScale - 1);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>) {
      const auto at = hn::LoadU(d, x + i), line = hn::LoadU(d, y + i);
      // inside only if that many bytes can be loaded in the row below
      put(i, hn::ShiftRight<5>(at), hn::ShiftRight<5>(line), s.width - 1, s.height - 1,
          (s.height - 1) * s.row() - s.wide + 1, s);
      hn::StoreU(hn::DemoteTo(words, hn::ShiftLeft<9>(hn::And(at, rest))), words, across + i);
      hn::StoreU(hn::DemoteTo(words, hn::And(line, rest)), words, down + i);
    }
  }

  template <int kStep>
  void read(const uint8_t* image, const Source& s, int64_t n, uint8_t* out) const {
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if constexpr (kStep > 0)
        if (inside[i]) i = read_inside<kStep>(image, s.row(), i, last, out);
      for (; i < last; ++i) read_one<kStep>(image, s, i, out + i * s.step);
    }
  }

 private:
  // Any position. Pixels outside are 0.
  template <int kStep>
  void read_one(const uint8_t* image, const Source& s, int64_t i, uint8_t* out) const {
    const int64_t step = kStep > 0 ? kStep : s.step;
    const int64_t column = x[i] >> 5, line = y[i] >> 5;
    const int32_t right = x[i] & 31, below = y[i] & 31;
    if (column < -1 || column >= s.width || line < -1 || line >= s.height) {
      std::memset(out, 0, static_cast<size_t>(step));
      return;
    }
    for (int64_t c = 0; c < step; ++c) {
      const auto pixel = [&](int64_t v, int64_t u) -> int32_t {
        return v < 0 || v >= s.height || u < 0 || u >= s.width ? 0 : image[v * s.row() + u * step + c];
      };
      const auto across_row = [&](int64_t v) {
        return pixel(v, column) * (32 - right) + pixel(v, column + 1) * right;
      };
      const int32_t sum = across_row(line) * (32 - below) + across_row(line + 1) * below;
      out[c] = static_cast<uint8_t>((sum + 512) >> 10);
    }
  }

  // Reads positions from i to last, whose pixels are inside; returns how many. The sum 32 a + f (b - a) is
  // taken down and then across. Only the quotient by 32 of the second product, which has 18 bits, is needed:
  // the high half of a product with f * 2^9.
  template <class D>
  HWY_INLINE static hn::Vec<D> down_of(D, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> weight) {
    return hn::Add(hn::ShiftLeft<5>(a), hn::Mul(hn::Sub(b, a), weight));
  }
  template <class D>
  HWY_INLINE static hn::Vec<D> across_of(D d, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> weight) {
    const auto part = hn::MulHigh(hn::ShiftLeft<2>(hn::Sub(b, a)), weight);
    return hn::ShiftRight<5>(hn::Add(hn::Add(a, part), hn::Set(d, int16_t{16})));
  }

  template <int kStep>
  int64_t read_inside(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    if constexpr (kStep == 1)
      return read_plane(image, row, i, last, out);
    else
      return read_frame<kStep>(image, row, i, last, out);
  }

  // Loads eight bytes for each pixel, which include the next pixel.
  template <int kStep>
  int64_t read_frame(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    using Part = hn::FixedTag<uint8_t, 8>;
    const hn::CappedTag<int16_t, 16> d;
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    constexpr auto kPixels = static_cast<int64_t>(hn::MaxLanes(d) / 8);
    alignas(32) uint8_t order[32];  // the pixel's weight, eight times
    for (size_t k = 0; k < 32; ++k) order[k] = static_cast<uint8_t>(k / 16 * 2 + k % 2);
    const hn::Repartition<uint8_t, decltype(d)> weights_bytes;
    const auto indices = hn::Load(weights_bytes, order);
    const auto weight = [=](const int16_t* p) {
      const auto all = hn::LoadDup128(weights_bytes, reinterpret_cast<const uint8_t*>(p));
      return hn::BitCast(d, hn::TableLookupBytes(all, indices));
    };
    const auto load = [=](const uint8_t* from, const int32_t* places) {
      return hn::PromoteTo(
          d, combined<Part>(bytes, [=](int64_t k) { return hn::LoadU(Part(), from + places[k / 8]); }));
    };
    // Four bytes are stored: the next position overwrites the excess one.
    for (; i + kPixels + 1 <= last; i += kPixels) {
      const auto tall = down_of(d, load(image, index + i), load(image + row, index + i), weight(down + i));
      const auto value = across_of(d, tall, hn::ShiftRightLanes<kStep>(d, tall), weight(across + i));
      alignas(16) uint8_t pixels[hn::MaxLanes(bytes)];
      hn::Store(hn::DemoteTo(bytes, value), bytes, pixels);
      for (int64_t k = 0; k < kPixels; ++k) std::memcpy(out + (i + k) * kStep, pixels + 8 * k, 4);
    }
    return i;
  }

  // Loads two bytes for each pixel, in one integer.
  int64_t read_plane(const uint8_t* image, int64_t row, int64_t i, int64_t last, uint8_t* out) const {
    const Lanes<int32_t> integers;
    const hn::RebindToUnsigned<decltype(integers)> d;
    const hn::Repartition<int16_t, decltype(d)> words;
    constexpr int64_t kPixels = kLanes<int32_t>;
    const auto load = [=, this](const uint8_t* from, int64_t at) {
      const auto four =
          hn::GatherOffset(d, reinterpret_cast<const uint32_t*>(from), hn::LoadU(integers, index + at));
      const auto byte = hn::Set(d, uint32_t{255});
      return hn::BitCast(
          words, hn::Or(hn::And(four, byte), hn::ShiftLeft<8>(hn::And(four, hn::ShiftLeft<8>(byte)))));
    };
    const auto weight = [=](const int16_t* p) {
      return hn::BitCast(d, hn::PromoteTo(integers, hn::LoadU(hn::Rebind<int16_t, decltype(integers)>(), p)));
    };
    for (; i + kPixels <= last; i += kPixels) {
      const auto both = weight(down + i);
      const auto tall = down_of(words, load(image, i), load(image + row, i),
                                hn::BitCast(words, hn::Or(both, hn::ShiftLeft<16>(both))));
      const auto next = hn::BitCast(words, hn::ShiftRight<16>(hn::BitCast(d, tall)));
      const auto value = across_of(words, tall, next, hn::BitCast(words, weight(across + i)));
      const auto level = hn::And(hn::BitCast(d, value), hn::Set(d, uint32_t{255}));
      const hn::Rebind<uint8_t, decltype(d)> bytes;
      hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, level)), bytes, out + i);
    }
    return i;
  }
};

// Weights of the four pixels along an axis around a position, by Keys' kernel with a = -0.75 (bicubic.h), for
// each fraction of 1/32, in units of 1/2^17.
struct CubicWeights {
  // In two parts, `high` in units of 1/2^10 and `low` in units of 1/2^17, as words: those of the first and
  // the third pixel, and those of the second and the last.
  struct Words {
    int32_t high[2], low[2];
  };
  alignas(64) int32_t whole[kScale][4];
  alignas(64) Words words[kScale];

  constexpr CubicWeights() : whole{}, words{} {
    const auto near = [](int32_t d) { return (5 * d - 288) * d * d + 131072; };
    const auto far = [](int32_t d) { return ((480 - 3 * d) * d - 24576) * d + 393216; };
    const auto pair = [](int32_t first, int32_t second) { return (first & 0xFFFF) + second * 65536; };
    for (int32_t t = 0; t < kScale; ++t) {
      int32_t* const w = whole[t];
      w[0] = far(kScale + t), w[1] = near(t), w[2] = near(kScale - t), w[3] = far(2 * kScale - t);
      for (int k = 0; k < 2; ++k) {
        words[t].high[k] = pair(w[k] >> kLow, w[k + 2] >> kLow);
        words[t].low[k] = pair(w[k] & kRest, w[k + 2] & kRest);
      }
    }
  }

  static constexpr int kLow = 7;
  static constexpr int32_t kRest = (1 << kLow) - 1;
};
constexpr CubicWeights kCubic;

// The shuffle of a row's bytes to words of two pixels, extended by zeros: four times the first and the third
// pixel, and four times the second and the last.
struct Order {
  alignas(16) uint8_t bytes[2][16];

  // For four channels of pixels of `step` bytes.
  static constexpr Order of_channels(int step) {
    return made([=](int lane, int pixel) { return pixel * step + lane; });
  }
  // For four positions with four pixels each.
  static constexpr Order of_positions() {
    return made([](int lane, int pixel) { return 4 * lane + pixel; });
  }

 private:
  template <class Place>
  static constexpr Order made(const Place& place) {
    Order order{};
    for (int lane = 0; lane < 4; ++lane)
      for (int k = 0; k < 4; ++k) {
        uint8_t* const word = order.bytes[k % 2] + 4 * lane + k / 2 * 2;
        word[0] = static_cast<uint8_t>(place(lane, k)), word[1] = 255;
      }
    return order;
  }
};

struct Bicubic : Places {
  static constexpr int32_t kUnknown = INT32_MIN;

  static int64_t loaded(int64_t step) { return step == 1 ? 4 : 16; }

  void find(const double* at_x, const double* at_y, int64_t n, const Source& s) {
    find_axis(at_x, n, s.width, s.padding, x);
    find_axis(at_y, n, s.height, s.padding, y);
    const Lanes<int32_t> d;
    const auto one = hn::Set(d, 1);
    for (int64_t i = 0; i < n; i += kLanes<int32_t>)
      // inside only if that many bytes can be loaded three rows below
      put(i, hn::Sub(hn::ShiftRight<5>(hn::LoadU(d, x + i)), one),
          hn::Sub(hn::ShiftRight<5>(hn::LoadU(d, y + i)), one), s.width - 3, s.height - 3,
          (s.height - 3) * s.row() - s.wide + 1, s);
  }

  static int64_t ahead(const Source& s) { return s.height > 3 ? 3 * s.row() : 0; }

  template <int kStep>
  void read(const uint8_t* image, const Source& s, int64_t n, uint8_t* out) const {
    for (int64_t i = 0; i < n;) {
      const int64_t last = end(i, n);
      if (inside[i]) {
        if constexpr (kStep == 1)
          for (; i + 4 <= last; i += 4) read_plane(image, s.row(), i, out + i);
        else if constexpr (kStep > 1)
          for (; i < last; ++i) {
            uint8_t made[4];
            read_pixel<kStep>(image + index[i], s.row(), i, made);
            if (i + 1 < n)
              std::memcpy(out + i * kStep, made, 4);  // the next position overwrites the excess byte
            else
              std::memcpy(out + i * kStep, made, kStep);
          }
      }
      for (; i < last; ++i) read_one<kStep>(image, s, i, out + i * s.step);
    }
  }

 private:
  // More than three pixels outside, results no longer change, unless positions are mirrored.
  static void find_axis(const double* at, int64_t n, int64_t size, Padding padding, int32_t* out) {
    const bool mirrored = padding == Padding::kReflection;
    limited_steps(at, n, kScale, kScale * (mirrored ? -double{kFurthest} : -4.0),
                  kScale * (mirrored ? double{kFurthest} : static_cast<double>(size + 3)), kUnknown, out);
  }

  // The indices of four pixels along an axis, -1 for pixels that do not exist.
  static std::array<int64_t, 4> pixels_read(int32_t at, int64_t size, const Source& s) {
    std::array<int64_t, 4> numbers;
    for (int32_t k = 0; k < 4; ++k) {
      const int32_t i = (at >> 5) - 1 + k;
      const bool there = i >= 0 && i < size;
      numbers[static_cast<size_t>(k)] = there                           ? i
                                        : s.padding == Padding::kZeros  ? -1
                                        : s.padding == Padding::kBorder ? std::clamp<int64_t>(i, 0, size - 1)
                                                                        : folded(i, size, 1, s.align_corners);
    }
    return numbers;
  }

  // Any position. Pixels outside are 0.
  template <int kStep>
  void read_one(const uint8_t* image, const Source& s, int64_t i, uint8_t* out) const {
    const auto step = static_cast<size_t>(kStep > 0 ? kStep : s.step);
    const auto is_pixel = [](int64_t number) { return number >= 0; };
    const bool known = x[i] != kUnknown && y[i] != kUnknown;
    const auto columns = pixels_read(x[i], s.width, s), lines = pixels_read(y[i], s.height, s);
    if (!known || std::none_of(columns.begin(), columns.end(), is_pixel) ||
        std::none_of(lines.begin(), lines.end(), is_pixel)) {
      std::memset(out, 0, step);
      return;
    }
    if constexpr (kStep > 1) {
      // Gathers the pixels into one block, and reads them like adjacent ones.
      alignas(16) uint8_t pixels[4][16] = {}, made[4];
      for (size_t j = 0; j < 4; ++j)
        for (size_t k = 0; k < 4; ++k)
          if (is_pixel(lines[j]) && is_pixel(columns[k]))
            std::memcpy(pixels[j] + k * kStep, image + lines[j] * s.row() + columns[k] * kStep, kStep);
      read_pixel<kStep>(pixels[0], 16, i, made);
      std::memcpy(out, made, kStep);
      return;
    }
    const int32_t *const across = kCubic.whole[x[i] & 31], *const down = kCubic.whole[y[i] & 31];
    for (size_t c = 0; c < step; ++c) {
      int64_t sum = int64_t{1} << 33;
      for (size_t j = 0; j < 4; ++j) {
        if (!is_pixel(lines[j])) continue;
        const uint8_t* const row = image + lines[j] * s.row() + c;
        int64_t along = 0;
        for (size_t k = 0; k < 4; ++k)
          if (is_pixel(columns[k])) along += int64_t{across[k]} * row[columns[k] * s.step];
        sum += down[j] * along;
      }
      out[c] = static_cast<uint8_t>(std::clamp<int64_t>(sum >> 34, 0, 255));
    }
  }

  using Bytes = hn::CappedTag<uint8_t, 32>;  // one row of 16 bytes, or two
  using Quads = hn::Repartition<int32_t, Bytes>;
  using Doubles = hn::CappedTag<double, 4>;
  static constexpr int kRowsAtOnce = static_cast<int>(hn::MaxLanes(Bytes()) / 16);

  // Four sums of 4 x 4 pixels, rounded, as bytes. load(j) returns the bytes of row j, and of the next row if
  // the vector has room for two; `order` picks the words of two pixels from them, four times. across(k)
  // returns the k-th pair of weights of either part, and down(j, part) the weights of row j.
  template <class Load, class Across, class Down>
  HWY_INLINE static void sum_rows(const uint8_t (&order)[2][16], const Load& load, const Across& across,
                                  const Down& down, uint8_t* out) {
    const Bytes bytes;
    const Quads quads;
    const hn::Repartition<int16_t, Bytes> words;
    const auto first = hn::LoadDup128(bytes, order[0]), second = hn::LoadDup128(bytes, order[1]);
    alignas(32) int32_t sums[4][4];
    for (int j = 0; j < 4; j += kRowsAtOnce) {
      const auto row = load(bytes, j);
      const auto even = hn::BitCast(words, hn::TableLookupBytesOr0(row, first)),
                 odd = hn::BitCast(words, hn::TableLookupBytesOr0(row, second));
      const auto sum = [&](int part) {
        auto total = hn::Zero(quads), other = total;
        total = hn::ReorderWidenMulAccumulate(quads, even, across(words, part, 0), total, other);
        total = hn::ReorderWidenMulAccumulate(quads, odd, across(words, part, 1), total, other);
        return hn::RearrangeToOddPlusEven(total, other);
      };
      hn::Store(hn::Add(hn::ShiftLeft<CubicWeights::kLow>(sum(0)), sum(1)), quads, sums[j]);
    }
    const Doubles d;
    const hn::Rebind<int32_t, Doubles> integers;
    const hn::Rebind<uint8_t, Doubles> levels;
    for (int64_t c = 0; c < 4; c += static_cast<int64_t>(hn::MaxLanes(d))) {
      const auto row = [&](int j) { return hn::PromoteTo(d, hn::LoadU(integers, sums[j] + c)); };
      auto total = hn::Mul(row(0), down(d, 0, c));
      for (int j = 1; j < 4; ++j) total = hn::MulAdd(row(j), down(d, j, c), total);  // exact
      const auto level = hn::MulAdd(total, hn::Set(d, 1.0 / 17179869184.0), hn::Set(d, 0.5));
      const auto limited = hn::Min(hn::Max(level, hn::Zero(d)), hn::Set(d, 255.5));
      hn::StoreU(hn::DemoteTo(levels, truncated(d, limited)), levels, out + c);
    }
  }

  // The channels of one position, from 4 x 4 pixels.
  template <int kStep>
  void read_pixel(const uint8_t* from, int64_t row, int64_t i, uint8_t* out) const {
    alignas(16) static constexpr Order kOrder = Order::of_channels(kStep);
    const auto& words_of = kCubic.words[x[i] & 31];
    const int32_t* const weights = kCubic.whole[y[i] & 31];
    sum_rows(
        kOrder.bytes,
        [=](auto bytes, int j) {
          const hn::FixedTag<uint8_t, 16> part;
          return combined<decltype(part)>(
              bytes, [=](int64_t k) { return hn::LoadU(part, from + (j + k / 16) * row); });
        },
        [&](auto words, int part, int k) {
          return hn::BitCast(words, hn::Set(Quads(), (part == 0 ? words_of.high : words_of.low)[k]));
        },
        [=](auto d, int j, int64_t) { return hn::Set(d, static_cast<double>(weights[j])); }, out);
  }

  // One channel at four positions.
  void read_plane(const uint8_t* image, int64_t row, int64_t i, uint8_t* out) const {
    alignas(16) static constexpr Order kOrder = Order::of_positions();
    // The weights of the four positions, next to each other.
    alignas(32) int32_t across[2][2][4], down[4][4];
    for (int p = 0; p < 4; ++p) {
      const auto& words_of = kCubic.words[x[i + p] & 31];
      const int32_t* const weights = kCubic.whole[y[i + p] & 31];
      for (int k = 0; k < 2; ++k) across[0][k][p] = words_of.high[k], across[1][k][p] = words_of.low[k];
      for (int j = 0; j < 4; ++j) down[j][p] = weights[j];
    }
    const int32_t* const places = index + i;
    sum_rows(
        kOrder.bytes,
        [=](auto bytes, int j) {
          const hn::FixedTag<uint8_t, 4> part;
          return combined<decltype(part)>(bytes, [=](int64_t k) {
            return hn::LoadU(part, image + places[k / 4 % 4] + (j + k / 16) * row);
          });
        },
        [&](auto words, int part, int k) {
          return hn::BitCast(words, hn::LoadDup128(Quads(), across[part][k]));
        },
        [&](auto d, int j, int64_t c) {
          return hn::PromoteTo(d, hn::LoadU(hn::Rebind<int32_t, decltype(d)>(), down[j] + c));
        },
        out);
  }
};

// Reads `each` images at positions(item, row, column, n, x, y), for each item.
template <class Taps, int kStep, class Positions>
void read_by(const uint8_t* images, int64_t items, int64_t each, const Source& source, int64_t out_height,
             int64_t out_width, uint8_t* out, const Positions& positions) {
  const int64_t blocks_y = (out_height + kRows - 1) / kRows, blocks_x = (out_width + kRun - 1) / kRun,
                size = source.height * source.row();
#pragma omp parallel for
  for (int64_t block = 0; block < items * blocks_y * blocks_x; ++block) {
    const int64_t left = block % blocks_x * kRun, top = block / blocks_x % blocks_y * kRows,
                  item = block / blocks_x / blocks_y;
    const int64_t n = std::min(kRun, out_width - left), bottom = std::min(top + kRows, out_height);
    const uint8_t* const first = images + item * each * size;
    const int64_t ahead = Taps::ahead(source);
    Taps rows[2];
    const auto find = [&](int64_t row) {
      double x[kRun], y[kRun];
      positions(item, row, left, n, x, y);
      rows[row % 2].find(x, y, n, source);
    };
    find(top);
    for (int64_t row = top; row < bottom; ++row) {
      if (row + 1 < bottom) {
        // Prefetch one row ahead, because hardware prefetchers miss this pattern.
        find(row + 1);
        for (int64_t i = 0; i < n; i += 8) hwy::Prefetch(first + rows[(row + 1) % 2].index[i] + ahead);
      }
      for (int64_t k = item * each; k < (item + 1) * each; ++k)
        rows[row % 2].template read<kStep>(images + k * size, source, n,
                                           out + ((k * out_height + row) * out_width + left) * source.step);
    }
  }
}

template <class Positions>
void read_at(const uint8_t* images, int64_t n, int64_t items, Source source, int64_t out_height,
             int64_t out_width, Interpolation mode, uint8_t* out, const Positions& positions) {
  const auto by = [&](auto step) {
    constexpr int kStep = decltype(step)::value;
    const auto read = [&](auto taps) {
      source.wide = decltype(taps)::type::loaded(source.step);
      read_by<typename decltype(taps)::type, kStep>(images, items, n / items, source, out_height, out_width,
                                                    out, positions);
    };
    switch (mode) {
      case Interpolation::kNearest: return read(std::type_identity<Nearest>());
      case Interpolation::kBilinear: return read(std::type_identity<Bilinear>());
      case Interpolation::kBicubic: return read(std::type_identity<Bicubic>());
    }
  };
  switch (source.step) {
    case 1: return by(std::integral_constant<int, 1>());
    case 3: return by(std::integral_constant<int, 3>());
    case 4: return by(std::integral_constant<int, 4>());
    default: return by(std::integral_constant<int, 0>());
  }
}

}  // namespace

template <class T>
void remap_bytes(const uint8_t* image, int64_t n, int64_t height, int64_t width, const T* x, int64_t items,
                 int64_t out_height, int64_t out_width, const T* y, int64_t step, Interpolation mode,
                 Padding padding, bool align_corners, uint8_t* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, out,
          [=](int64_t item, int64_t row, int64_t column, int64_t count, double* to_x, double* to_y) {
            const int64_t start = (item * out_height + row) * out_width + column;
            std::copy_n(x + start, count, to_x);
            std::copy_n(y + start, count, to_y);
          });
}

void warp_bytes(const uint8_t* image, int64_t n, int64_t height, int64_t width, const double* matrix,
                int64_t items, int64_t out_height, int64_t out_width, int64_t step, Interpolation mode,
                Padding padding, bool align_corners, uint8_t* out) {
  read_at(image, n, items, {height, width / step, step, 0, padding, align_corners}, out_height, out_width,
          mode, out, [=](int64_t item, int64_t row, int64_t column, int64_t count, double* x, double* y) {
            // In the same order as the definition, so that positions are equal.
            const double *const m = matrix + 9 * item, v = static_cast<double>(row);
            const double a = m[0], b = m[1] * v, c = m[2], d = m[3], e = m[4] * v, f = m[5], g = m[6],
                         h = m[7] * v, k = m[8];
            const auto first = static_cast<int32_t>(column), n = static_cast<int32_t>(count);
            for (int32_t i = 0; i < n; ++i) {
              x[i] = a * (first + i) + b + c;
              y[i] = d * (first + i) + e + f;
            }
            if (g == 0 && m[7] == 0 && k == 1) return;
            for (int32_t i = 0; i < n; ++i) {
              const double depth = g * (first + i) + h + k;
              const double divisor = std::abs(depth) > 1e-8 ? depth : 1e-8;
              x[i] /= divisor;
              y[i] /= divisor;
            }
          });
}

CHIASM_INSTANTIATE(remap_bytes)

}  // namespace chiasm::kernels
