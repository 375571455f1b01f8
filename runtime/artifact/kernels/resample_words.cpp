// Resampling of 16-bit pixels by any taps, down the columns and then along the rows. Sums of whole numbers
// below 2^53 are exact in double, so their order does not matter.
#include <bit>
#include <cmath>

#include "declared/resample_words.h"
#include "words.h"

namespace chiasm::kernels {
namespace {

using Four = hn::CappedTag<double, 4>;
constexpr auto kFour = static_cast<int64_t>(hn::MaxLanes(Four()));

// The pixels that are summed, and their weights, for each pixel along an axis.
struct Axis {
  Axis(const int64_t* numbers, const int64_t* taps, int64_t count, int64_t each, int64_t size)
      : count(count),
        each(each),
        index(static_cast<size_t>(count * each)),
        weight(taps, taps + count * each) {
    for (size_t i = 0; i < index.size(); ++i)
      index[i] = static_cast<int32_t>(std::clamp<int64_t>(numbers[i], 0, size - 1));
  }

  const int64_t count, each;
  std::vector<int32_t> index;
  std::vector<double> weight;
};

// The k-th pixels and weights of all pixels along an axis, for each k, so that vectors can load them.
struct Columns {
  explicit Columns(const Axis& axis) : index(axis.index.size()), weight(axis.weight.size()) {
    for (int64_t i = 0; i < axis.count; ++i)
      for (int64_t k = 0; k < axis.each; ++k) {
        const auto from = static_cast<size_t>(i * axis.each + k),
                   to = static_cast<size_t>(k * axis.count + i);
        index[to] = axis.index[from];
        weight[to] = axis.weight[from];
      }
  }

  std::vector<int32_t> index;
  std::vector<double> weight;
};

// The weighted sum of rows, the k-th at image + index[k] * n. Rows with a weight of 0 are not read.
template <class S>
void sum_rows(const S* image, const Axis& down, int64_t row, int64_t n, double* out) {
  const int32_t* const index = down.index.data() + row * down.each;
  const double* const weight = down.weight.data() + row * down.each;
  bool first = true;
  const auto add = [&](auto several, int64_t k) {
    const S* const a = image + index[k] * n;
    const S* const b = image + (several ? index[k + 1] : index[k]) * n;
    const double of_a = weight[k], of_b = several ? weight[k + 1] : 0;
    const bool begins = first;
    for_lanes<double, 2>(n, [=](auto d, auto vectors, int64_t i) {
      constexpr auto kEach = static_cast<int64_t>(hn::MaxLanes(d));
      for (int v = 0; v < vectors; ++v) {
        const int64_t at = i + v * kEach;
        auto sum = hn::Mul(numbers_of(d, a + at), hn::Set(d, of_a));
        if constexpr (decltype(several)::value)
          sum = hn::Add(sum, hn::Mul(numbers_of(d, b + at), hn::Set(d, of_b)));
        hn::StoreU(begins ? sum : hn::Add(hn::LoadU(d, out + at), sum), d, out + at);
      }
    });
    first = false;
  };
  for (int64_t k = 0; k < down.each;) {
    if (weight[k] == 0) {
      ++k;
    } else if (k + 1 < down.each && weight[k + 1] != 0) {
      add(std::true_type(), k);
      k += 2;
    } else {
      add(std::false_type(), k++);
    }
  }
  if (first) std::fill_n(out, n, 0.0);
}

// Rows are summed along their length. They have room for four values after their end, as the results have.
class Across {
 public:
  Across(Axis axis, int64_t step) : axis_(std::move(axis)), columns_(axis_), step_(step) {}

  void operator()(const double* row, double* out) const {
    switch (step_) {
      case 1: return plane(row, out);
      case 3: return frame<3>(row, out);
      case 4: return frame<4>(row, out);
      default: return values(row, out);
    }
  }

 private:
  void plane(const double* row, double* out) const {
    const int64_t count = axis_.count, each = axis_.each;
    const int32_t* const index = columns_.index.data();
    const double* const weight = columns_.weight.data();
    for_lanes<double>(count, [=](auto d, auto, int64_t i) {
      auto sum = hn::Zero(d);
      for (int64_t k = 0; k < each; ++k)
        sum = hn::Add(sum,
                      hn::Mul(gathered(d, row, index + k * count + i), hn::LoadU(d, weight + k * count + i)));
      hn::StoreU(sum, d, out + i);
    });
  }

  // Loads and stores four values; the next pixel overwrites an excess one.
  template <int kStep>
  void frame(const double* row, double* out) const {
    const Four d;
    for (int64_t i = 0; i < axis_.count; ++i) {
      const int32_t* const index = axis_.index.data() + i * axis_.each;
      const double* const weight = axis_.weight.data() + i * axis_.each;
      for (int64_t c = 0; c < 4; c += kFour) {
        auto sum = hn::Zero(d);
        for (int64_t k = 0; k < axis_.each; ++k)
          sum =
              hn::Add(sum, hn::Mul(hn::LoadU(d, row + int64_t{index[k]} * kStep + c), hn::Set(d, weight[k])));
        hn::StoreU(sum, d, out + i * kStep + c);
      }
    }
  }

  void values(const double* row, double* out) const {
    for (int64_t i = 0; i < axis_.count; ++i)
      for (int64_t c = 0; c < step_; ++c) {
        double sum = 0;
        for (int64_t k = i * axis_.each; k < (i + 1) * axis_.each; ++k)
          sum += row[axis_.index[static_cast<size_t>(k)] * step_ + c] * axis_.weight[static_cast<size_t>(k)];
        out[i * step_ + c] = sum;
      }
  }

  Axis axis_;
  Columns columns_;
  int64_t step_;
};

// sums / total, rounded half up and saturated.
template <class S>
void divide(const double* sums, int64_t n, int64_t total, S* out) {
  constexpr double least = std::numeric_limits<S>::min(), largest = std::numeric_limits<S>::max();
  const auto divided = [=](const auto& quotient) {
    for_lanes<double, 4>(n, [=](auto d, auto vectors, int64_t i) {
      const hn::Rebind<S, decltype(d)> words;
      constexpr auto kEach = static_cast<int64_t>(hn::MaxLanes(d));
      for (int v = 0; v < vectors; ++v) {
        const int64_t at = i + v * kEach;
        const auto whole = hn::Floor(quotient(d, hn::LoadU(d, sums + at)));
        const auto level = smaller(larger(whole, hn::Set(d, least)), hn::Set(d, largest));
        hn::StoreU(hn::DemoteTo(words, truncated(d, level)), words, out + at);
      }
    });
  };
  const auto divisor = static_cast<double>(total);
  if (std::has_single_bit(static_cast<uint64_t>(total)))  // then a product is exact
    divided(
        [=](auto d, auto sum) { return hn::Add(hn::Mul(sum, hn::Set(d, 1 / divisor)), hn::Set(d, 0.5)); });
  else
    divided([=](auto d, auto sum) {
      return hn::Div(hn::Add(hn::Add(sum, sum), hn::Set(d, divisor)), hn::Set(d, 2 * divisor));
    });
}

}  // namespace

template <class S>
void resample_words(const S* x, int64_t n, int64_t height, int64_t width, const int64_t* rows,
                    int64_t new_height, int64_t most_down, const int64_t* down, const int64_t* columns,
                    int64_t new_width, int64_t most_across, const int64_t* across, const int64_t* total,
                    int64_t step, S* out) {
  const Axis tall(rows, down, new_height, most_down, height);
  const Across wide(Axis(columns, across, new_width, most_across, width / step), step);
  const int64_t values = new_width * step, room = whole_lines<double>(width + 4),
                room_made = whole_lines<double>(values + 4);
  const auto memory = new_lines<double>((room + room_made) * omp_get_max_threads());
#pragma omp parallel for
  for (int64_t i = 0; i < n * new_height; ++i) {
    double* const summed = memory.get() + (room + room_made) * omp_get_thread_num();
    double* const made = summed + room;
    sum_rows(x + i / new_height * height * width, tall, i % new_height, width, summed);
    std::fill_n(summed + width, 4, 0.0);
    wide(summed, made);
    divide(made, values, *total, out + i * values);
  }
}

CHIASM_INSTANTIATE(resample_words)

}  // namespace chiasm::kernels
