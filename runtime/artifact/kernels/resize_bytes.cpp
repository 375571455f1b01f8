// Resizing of bytes: bilinear in fixed point, and to the nearest pixel.
//
// A row is first resampled along its length, into 16-bit sums that are kept for the next row of the output.
// Then two such rows are weighted, the high and the low bytes of their sums separately.
#include <array>
#include <cstring>

#include "declared/resize_bytes.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

using Word = uint16_t;
using Eight = hn::FixedTag<Word, 8>;

// Along an axis: `count` pixels of an image, from `begin` on, are resized to `length` pixels of the output,
// from `to` on. Both ranges may reach beyond the image or the output.
struct Window {
  int64_t begin, count, to, length;
};

// The pixels that each position along an axis reads: pixel `first`, and the next one with `weight` / 256.
// Only for the pixels of the output that are in a window, from `start` on.
struct Axis {
  int64_t start = 0;
  std::vector<int64_t> first;
  std::vector<int32_t> weight;

  Axis(int64_t in, int64_t out, bool align_corners) : Axis(in, {0, in, 0, out}, out, align_corners) {}

  Axis(int64_t in, const Window& window, int64_t out, bool align_corners) {
    const int64_t count = window.count, length = window.length;
    if (count < 1 || length < 1) return;
    start = std::clamp<int64_t>(window.to, 0, out);
    const int64_t end = std::clamp<int64_t>(window.to + length, 0, out),
                  denominator = align_corners ? std::max<int64_t>(length - 1, 1) : 2 * length;
    first.reserve(static_cast<size_t>(end - start));
    weight.reserve(first.capacity());
    for (int64_t i = start - window.to; i < end - window.to; ++i) {
      const int64_t numerator =
          std::max<int64_t>(align_corners ? i * (count - 1) : (2 * i + 1) * count - length, 0);
      const int64_t whole = std::min(numerator / denominator, count - 1),
                    rest = numerator - whole * denominator, at = window.begin + whole;
      first.push_back(std::clamp<int64_t>(at, 0, in - 1));
      // The window's last pixel has no next one, and beyond the image all pixels equal that at the edge.
      const bool alone = whole == count - 1 || at < 0 || at >= in - 1;
      weight.push_back(alone ? 0 : static_cast<int32_t>((512 * rest + denominator) / (2 * denominator)));
    }
  }

  int64_t size() const { return static_cast<int64_t>(first.size()); }
};

// Resamples a row. For each pixel of the output it has the place of the two pixels that are summed, and, for
// pixels of three or four bytes, their weights byte by byte.
class Across {
 public:
  Across(Axis axis, int64_t in, int64_t step)
      : axis_(std::move(axis)), in_(in), out_(axis_.size()), step_(step) {
    for (auto& first : axis_.first) {
      // The last pixel has no next one: it is read with the one before.
      const auto i = static_cast<size_t>(&first - axis_.first.data());
      if (in > 1 && first == in - 1) {
        --first;
        axis_.weight[i] = 256;
      }
      if (step * first + 8 <= step * in) wide_ = static_cast<int64_t>(i) + 1;
    }
    if (step != 3 && step != 4) return;
    weights_.resize(static_cast<size_t>(8 * out_));
    for (int64_t x = 0; x < out_; ++x)
      for (int64_t k = 0; k < 2 * step; ++k) {
        const int32_t second = axis_.weight[static_cast<size_t>(x)];
        weights_[static_cast<size_t>(8 * x + k)] = static_cast<Word>(k < step ? 256 - second : second);
      }
  }

  // Room for a row: vectors of eight run over its end.
  int64_t room() const { return whole_lines<Word>(out_ * step_ + 8); }
  int64_t start() const { return axis_.start; }
  int64_t size() const { return out_; }

  void operator()(const uint8_t* row, Word* out) const {
    int64_t x = 0;
    if (in_ > 1 && step_ == 3)
      x = by_pixels<3>(row, out);
    else if (in_ > 1 && step_ == 4)
      x = by_pixels<4>(row, out);
    for (; x < out_; ++x) {
      const auto i = static_cast<size_t>(x);
      const uint8_t* const p = row + axis_.first[i] * step_;
      const int32_t second = axis_.weight[i];
      for (int64_t c = 0; c < step_; ++c)
        out[x * step_ + c] = static_cast<Word>(p[c] * (256 - second) + (in_ > 1 ? p[step_ + c] * second : 0));
    }
  }

 private:
  // Returns the number of pixels that it has computed: those for which eight bytes may be read.
  template <int kStep>
  int64_t by_pixels(const uint8_t* row, Word* out) const {
    const Eight d;
    const hn::Rebind<uint8_t, Eight> bytes;
    const int64_t* const first = axis_.first.data();
    const Word* const weights = weights_.data();
    for (int64_t x = 0; x < wide_; ++x) {
      const auto both =
          hn::Mul(hn::PromoteTo(d, hn::LoadU(bytes, row + first[x] * kStep)), hn::LoadU(d, weights + 8 * x));
      hn::StoreU(hn::Add(both, hn::ShiftRightLanes<kStep>(d, both)), d, out + x * kStep);
    }
    return wide_;
  }

  Axis axis_;
  const int64_t in_, out_, step_;
  int64_t wide_ = 0;
  std::vector<Word> weights_;
};

// (upper * (256 - second) + lower * second) / 2^16, rounded half up.
void blend(const Word* upper, const Word* lower, int32_t second, int64_t n, uint8_t* out) {
  const auto above = static_cast<Word>(256 - second), below = static_cast<Word>(second);
  for_lanes<Word, 2>(n, [=](auto d, auto vectors, int64_t k) {
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    const hn::RebindToSigned<decltype(d)> integers;
    const auto byte = hn::Set(d, Word{255}), first = hn::Set(d, above), next = hn::Set(d, below);
    const auto lanes = static_cast<int64_t>(hn::Lanes(d));
    for (int v = 0; v < vectors; ++v) {
      const auto a = hn::LoadU(d, upper + k + v * lanes), b = hn::LoadU(d, lower + k + v * lanes);
      const auto high = hn::Add(hn::Mul(hn::ShiftRight<8>(a), first), hn::Mul(hn::ShiftRight<8>(b), next));
      const auto low = hn::Add(hn::Mul(hn::And(a, byte), first), hn::Mul(hn::And(b, byte), next));
      const auto sum = hn::Add(hn::Add(high, hn::ShiftRight<8>(low)), hn::Set(d, Word{128}));
      hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(integers, hn::ShiftRight<8>(sum))), bytes,
                 out + k + v * lanes);
    }
  });
}

// Resamples an image row by row, and keeps two resampled rows and their numbers.
class KeptRows {
 public:
  KeptRows(const uint8_t* image, int64_t height, int64_t width, const Across& across, Word* memory)
      : image_(image),
        height_(height),
        width_(width),
        across_(across),
        rows_{memory, memory + across.room()} {}

  // Blends the two rows at a vertical position, n values.
  void blended(const Axis& down, int64_t position, int64_t n, uint8_t* out) {
    const auto at = static_cast<size_t>(position);
    const int64_t first = down.first[at], next = std::min(first + 1, height_ - 1);
    const int32_t weight = down.weight[at];
    const Word* const upper = get(first, next);
    const Word* const lower = weight == 0 ? upper : get(next, first);
    blend(upper, lower, weight, n, out);
  }

 private:
  // Row y, resampled; the row `other` is kept.
  const Word* get(int64_t y, int64_t other) {
    for (size_t i = 0; i < 2; ++i)
      if (known_[i] == y) return rows_[i];
    const size_t i = known_[0] == other ? 1 : 0;
    across_(image_ + y * width_, rows_[i]);
    known_[i] = y;
    return rows_[i];
  }

  const uint8_t* const image_;
  const int64_t height_, width_;
  const Across& across_;
  std::array<Word*, 2> rows_;
  std::array<int64_t, 2> known_{-1, -1};
};

constexpr int64_t kRows = 32;

// The coordinates of windows are limited to this, so that positions fit into 64-bit integers.
constexpr int64_t kFarthest = int64_t{1} << 24;

}  // namespace

void resize_bytes(const uint8_t* x, int64_t n, int64_t height, int64_t width, int64_t new_height,
                  int64_t new_width, int64_t step, bool align_corners, uint8_t* out) {
  const Axis down(height, new_height, align_corners);
  const Across across(Axis(width / step, new_width, align_corners), width / step, step);
  const int64_t blocks = (new_height + kRows - 1) / kRows, values = new_width * step;
  const auto memory = new_lines<Word>(2 * across.room() * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < n * blocks; ++i) {
    const int64_t top = i % blocks * kRows, image = i / blocks;
    KeptRows rows(x + image * height * width, height, width, across,
                  memory.get() + 2 * across.room() * omp_get_thread_num());
    for (int64_t y = top; y < std::min(top + kRows, new_height); ++y)
      rows.blended(down, y, values, out + (image * new_height + y) * values);
  }
}

void placed_bytes(const uint8_t* x, int64_t /*n*/, int64_t height, int64_t width, const int64_t* images,
                  int64_t m, const int64_t* boxes, int64_t new_height, int64_t new_width, int64_t step,
                  int64_t pad, uint8_t* out) {
  std::vector<Axis> downs;
  std::vector<Across> acrosses;
  downs.reserve(static_cast<size_t>(m));
  acrosses.reserve(static_cast<size_t>(m));
  int64_t room = 0;
  for (int64_t i = 0; i < m; ++i) {
    const auto window = [&](int64_t axis) {
      const auto entry = [&](int64_t k) {
        return std::clamp<int64_t>(boxes[8 * i + axis + k], -kFarthest, kFarthest);
      };
      return Window{entry(0), entry(2), entry(4), entry(6)};
    };
    downs.emplace_back(height, window(1), new_height, false);
    acrosses.emplace_back(Axis(width / step, window(0), new_width, false), width / step, step);
    room = std::max(room, acrosses.back().room());
  }
  const int64_t blocks = (new_height + kRows - 1) / kRows, values = new_width * step;
  const auto memory = new_lines<Word>(2 * room * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < m * blocks; ++i) {
    const int64_t top = i % blocks * kRows, item = i / blocks;
    const Axis& down = downs[static_cast<size_t>(item)];
    const Across& across = acrosses[static_cast<size_t>(item)];
    KeptRows rows(x + images[item] * height * width, height, width, across,
                  memory.get() + 2 * room * omp_get_thread_num());
    for (int64_t y = top; y < std::min(top + kRows, new_height); ++y) {
      uint8_t* const row = out + (item * new_height + y) * values;
      const int64_t left = across.start() * step, count = across.size() * step;
      if (y < down.start || y >= down.start + down.size() || count == 0) {
        std::memset(row, static_cast<int>(pad), static_cast<size_t>(values));
        continue;
      }
      std::memset(row, static_cast<int>(pad), static_cast<size_t>(left));
      rows.blended(down, y - down.start, count, row + left);
      std::memset(row + left + count, static_cast<int>(pad), static_cast<size_t>(values - left - count));
    }
  }
}

template <class P>
void resize_nearest(const P* x, int64_t n, int64_t height, int64_t width, int64_t new_height,
                    int64_t new_width, int64_t step, P* out) {
  const int64_t pixels = width / step;
  std::vector<int64_t> from(static_cast<size_t>(new_width));
  for (int64_t i = 0; i < new_width; ++i) from[static_cast<size_t>(i)] = i * pixels / new_width * step;
  const int64_t* const places = from.data();
#pragma omp parallel for
  for (int64_t row = 0; row < n * new_height; ++row) {
    const P* const source = x + (row / new_height * height + row % new_height * height / new_height) * width;
    P* const target = out + row * new_width * step;
    const auto copy = [=](auto count) {
      for (int64_t i = 0; i < new_width; ++i)
        std::memcpy(target + i * count, source + places[i], sizeof(P) * count);
    };
    switch (step) {
      case 1: copy(std::integral_constant<size_t, 1>()); break;
      case 3: copy(std::integral_constant<size_t, 3>()); break;
      case 4: copy(std::integral_constant<size_t, 4>()); break;
      default: copy(static_cast<size_t>(step));
    }
  }
}

CHIASM_INSTANTIATE(resize_nearest)

}  // namespace chiasm::kernels
