// Calls every kernel like compiled ops do, with sizes that leave parts of vectors and strips, every border
// and special values, and with guards around every tensor. Other tests check the results; here a kernel must
// stay in its memory, give the same results wherever that is, and end. Most calls are made from the kernels'
// declarations (guarded_calls.inc, by runtime/artifact/generate.py); written here are those for which a
// kernel has a loop of its own that such calls do not reach, or whose results have to be in a range.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "calls.h"
#include "fixture.h"
#include "results.h"

using namespace chiasm::artifact;
using kernel_calls::kCode;
using kernel_calls::Results;
using kernel_calls::Tensor;

namespace {

enum class Fill { kOrdinary, kSpecial, kMixed };

struct Size {
  int64_t height, width;
};
// A pixel, a row, a column, less than a vector and slightly more, parts of two and of four vectors, more than
// a tile's rows.
constexpr Size kSizes[] = {{1, 1}, {1, 2}, {2, 1},  {2, 2},  {1, 9},  {9, 1},  {3, 4},   {4, 3},   {5, 7},
                           {7, 8}, {8, 9}, {9, 15}, {3, 17}, {6, 31}, {3, 33}, {67, 35}, {2, 261}, {261, 2}};
constexpr int64_t kBorders = 4;

// The placements of tensors. One is enough for slow tests with another purpose: results under an emulator,
// races.
#ifdef CHIASM_ONE_PLACEMENT
constexpr guarded::Placement kPlacements[] = {guarded::Placement::kEnd};
#else
constexpr guarded::Placement kPlacements[] = {guarded::Placement::kEnd, guarded::Placement::kStart};
#endif

class Guarded : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  // Runs `calls` with tensors that end, and again with tensors that begin, at inaccessible memory.
  template <class Calls>
  void watch(const Calls& calls,
             std::initializer_list<Fill> fills = {Fill::kOrdinary, Fill::kSpecial, Fill::kMixed}) {
    Results known;
    for (const Fill fill : fills) {
      std::vector<std::vector<char>> results[2];
      for (const guarded::Placement placement : kPlacements) {
        kernel_calls::placement = placement;
        kernel_calls::damaged = 0;
        fill_ = fill;
        results_ = &results[placement == guarded::Placement::kStart];
        known_ = placement == guarded::Placement::kEnd ? &known : nullptr;
        calls();
        ASSERT_EQ(kernel_calls::damaged, 0) << "tensors beside which something was written";
      }
      if (std::size(kPlacements) == 1) continue;
      ASSERT_EQ(results[0].size(), results[1].size());
      for (size_t i = 0; i < results[0].size(); ++i)
        ASSERT_EQ(results[0][i], results[1][i]) << "call " << i << " depends on where its tensors lie";
    }
  }

  template <class T>
  T number(double low, double high) {
    using Limits = std::numeric_limits<T>;
    static constexpr T kSpecial[] = {Limits::quiet_NaN(),
                                     Limits::infinity(),
                                     -Limits::infinity(),
                                     T(0),
                                     T(-0.0),
                                     Limits::denorm_min(),
                                     T(1e10),
                                     T(-1e10),
                                     T(3e9),
                                     T(-3e9),
                                     T(2147483648.0),
                                     T(-2147483648.0),
                                     T(1e38),
                                     T(-1e38),
                                     Limits::max(),
                                     Limits::lowest(),
                                     T(-0.5),
                                     T(0.5),
                                     T(255.5)};
    const bool special = fill_ == Fill::kSpecial || (fill_ == Fill::kMixed && engine_() % 16 == 0);
    if (special) return kSpecial[engine_() % std::size(kSpecial)];
    return static_cast<T>(std::uniform_real_distribution<double>(low, high)(engine_));
  }

  template <class T>
  Tensor numbers_of(const Dims& sizes, double low, double high) {
    Tensor tensor = kernel_calls::make(sizes, kCode<T>);
    seed(sizes, low, high);
    auto* const data = reinterpret_cast<T*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i) data[i] = number<T>(low, high);
    return tensor;
  }

  // Compilers evaluate a call's arguments in different orders. So an argument's random numbers depend only on
  // the call and on the argument, not on those made before.
  void seed(const Dims& sizes, double low, double high) {
    std::vector<int64_t> what(sizes.begin(), sizes.end());
    what.insert(what.end(), {static_cast<int64_t>(results_->size()), std::bit_cast<int64_t>(low),
                             std::bit_cast<int64_t>(high)});
    std::seed_seq words(what.begin(), what.end());
    engine_.seed(words);
  }

  template <class Whole>
  Tensor wholes(const Dims& sizes, int64_t low, int64_t high) {
    Tensor tensor = kernel_calls::make(sizes, kCode<Whole>);
    seed(sizes, static_cast<double>(low), static_cast<double>(high));
    auto* const data = reinterpret_cast<Whole*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i)
      data[i] = static_cast<Whole>(std::uniform_int_distribution<int64_t>(low, high)(engine_));
    return tensor;
  }

  Tensor doubles(const Dims& sizes) { return numbers_of<double>(sizes, 0, 1); }

  // For images (N, H, L): a few pixels, a disk and a box without a corner, all with an anchor outside the
  // centre.
  void shapes_of_windows(const Tensor& x, int64_t step) {
    const Tensor few = kernel_calls::of<double>({3, 2}, {0, -1e4, -1e4, 0, 0, 0}),
                 disk = kernel_calls::of<double>(
                     {5, 4}, {-1e4, 0, 0, -1e4, 0, 0, 0, 0, 0, 0, 0, -1e4, 0, 0, 0, 0, -1e4, 0, -1e4, 0}),
                 box = kernel_calls::of<double>({2, 3}, {-1e4, 0, 0});
    for (int64_t border = 0; border < kBorders; ++border)
      for (const Tensor* window : {&few, &disk, &box}) {
        run(aoti_torch_cpu_morphology, x, step, *window, int64_t{0}, int64_t{0}, border, 0.5, 1e4,
            int32_t{1});
        run(aoti_torch_cpu_morphology_gradient, x, step, *window, *window, int64_t{1}, int64_t{1}, border,
            0.5, 0.25, 1e4);
      }
  }

  // For rows (N, H, L) of several strips.
  void wide_windows(const Tensor& x, int64_t step) {
    shapes_of_windows(x, step);
    for (int64_t border = 0; border < kBorders; ++border) {
      run(aoti_torch_cpu_minmax_filter, x, step, int64_t{5}, int64_t{33}, border, 0.5, int32_t{1});
      run(aoti_torch_cpu_median_filter, x, step, int64_t{5}, border);
    }
  }

  // A call that must succeed: call(arguments..., result).
  template <class... Parameters, class... Arguments>
  Tensor run(Call (*call)(Parameters...), const Arguments&... arguments) {
    Handle result = nullptr;
    EXPECT_EQ(call(bare(arguments)..., &result), 0) << kernel_calls::last_error;
    Tensor tensor(result);
    if (!tensor) return tensor;
    results_->emplace_back(tensor->data(), tensor->data() + tensor->storage->bytes);
    if (known_ != nullptr)
      known_->see(*tensor, !is_inexact(reinterpret_cast<void (*)()>(call)) ? Results::kExact
                           : fill_ == Fill::kOrdinary                      ? Results::kRounded
                                                                           : Results::kAny);
    return tensor;
  }

  // Calls whose sums, exponentials or angles depend on the vector length or on a library, so huge numbers may
  // or may not overflow.
  static bool is_inexact(void (*call)());

  static Handle bare(const Tensor& tensor) { return tensor.get(); }
  template <class Number>
  static Number bare(Number number) {
    return number;
  }

  Fill fill_ = Fill::kOrdinary;
  std::mt19937 engine_;
  std::vector<std::vector<char>>* results_ = nullptr;
  Results* known_ = nullptr;
};

template <class T>
class GuardedKernels : public Guarded {
 protected:
  Tensor numbers(const Dims& sizes, double low = 0, double high = 1) {
    return numbers_of<T>(sizes, low, high);
  }
};

// The calls that are made from the declarations: the tensors of an argument with a number.
class GuardedCalls : public Guarded {
 protected:
  // Any value that the type has: bytes of all kinds, and of numbers mostly those that may be positions,
  // colours and weights.
  template <class T>
  Tensor any(int argument, const Dims& sizes) {
    Tensor tensor = kernel_calls::make(sizes, kCode<T>);
    seed(sizes, argument, 0);
    const auto range = kRanges[engine_() % std::size(kRanges)];
    // A caller's bools may have any byte values.
    using Value = std::conditional_t<std::is_same_v<T, bool>, uint8_t, T>;
    auto* const data = reinterpret_cast<Value*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i)
      if constexpr (std::is_floating_point_v<T>)
        data[i] = number<T>(range.low, range.high);
      else if constexpr (std::is_same_v<T, bool>)
        data[i] = static_cast<Value>(engine_() % 4);
      else
        data[i] = whole<T>();
    return tensor;
  }

  template <class T>
  T whole() {
    const auto between = [&](int64_t low, int64_t high) {
      return static_cast<T>(std::uniform_int_distribution<int64_t>(low, high)(engine_));
    };
    using Limits = std::numeric_limits<T>;
    if constexpr (sizeof(T) > 2) {
      const bool special = fill_ == Fill::kSpecial || (fill_ == Fill::kMixed && engine_() % 16 == 0);
      // Magnitudes up to those of weights (int32) or of positions (int64), each power of two as likely as the
      // others; most numbers are positive.
      const int64_t most = int64_t{1} << engine_() % (sizeof(T) == 4 ? 23 : 8);
      if (!special) return between(engine_() % 8 ? 0 : -most, most);
      static constexpr T kSpecial[] = {Limits::min(), Limits::max(), Limits::min() + 1, Limits::max() / 2,
                                       -1};
      if (engine_() % 2) return kSpecial[engine_() % std::size(kSpecial)];
    }
    return between(Limits::min(), Limits::max());
  }

  // Whole numbers, for an argument whose callers promise more than its kernel can check.
  template <class T>
  Tensor whole_numbers(int argument, const Dims& sizes, int64_t low, int64_t high) {
    Tensor tensor = kernel_calls::make(sizes, kCode<T>);
    seed(sizes, argument, 1);
    auto* const data = reinterpret_cast<T*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i)
      data[i] = static_cast<T>(std::uniform_int_distribution<int64_t>(low, high)(engine_));
    return tensor;
  }

  template <size_t count>
  static Tensor entries(const Dims& sizes, const int64_t (&values)[count]) {
    return kernel_calls::of(sizes, std::vector<int64_t>(std::begin(values), std::end(values)));
  }

  // body(T{}) for each type; `others`: tensors of other types have special values, too.
  template <class... Types, class Body>
  void each(bool others, const Body& body) {
    ((fill_ == Fill::kOrdinary || others || sizeof(Types) > 2 ? body(Types{}) : void()), ...);
  }

 private:
  static constexpr struct { double low, high; } kRanges[] = {{0, 1}, {-1, 1}, {-5, 70}};
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(GuardedKernels, Types);

TYPED_TEST(GuardedKernels, WideRowsStayInside) {
  this->watch([&] {
    for (int64_t border = 0; border < kBorders; ++border) {
      const Tensor x = this->numbers({1, 1, 3, 30011});
      this->run(aoti_torch_cpu_separable, x, this->numbers({1, 3}), this->numbers({1, 3}), border, 1.0, 0.0);
      this->run(aoti_torch_cpu_correlate2d, x, this->numbers({1, 3, 3}), border);
    }
    this->run(aoti_torch_cpu_sobel, this->numbers({1, 1, 3, 30011}), 0.125, 1e-6);
    this->run(aoti_torch_cpu_canny_nms, this->numbers({1, 1, 3, 30011}), 1e-6);
  });
}

TYPED_TEST(GuardedKernels, ShapesOfWindowsStayInside) {
  this->watch([&] {
    int64_t step = 1;
    for (const Size& s : kSizes) {
      step = 4 - step;  // 3, 1, 3, ...
      this->shapes_of_windows(this->numbers({2, s.height, s.width * step}), step);
    }
    this->wide_windows(this->numbers({1, 3, 12000}), 3);
  });
}

// The image is its own guide.
TYPED_TEST(GuardedKernels, BilateralStaysInside) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (int64_t border = 0; border < kBorders; ++border) {
        const Tensor x = this->numbers({2, 2, s.height, s.width});
        this->run(aoti_torch_cpu_bilateral, x, x, this->numbers({1, 3, 5}), this->numbers({1}, -5, 0), border,
                  int32_t{0});
        this->run(aoti_torch_cpu_bilateral, x, x, this->numbers({1, 1, 1}), this->numbers({1}, -5, 0), border,
                  int32_t{1});
      }
  });
}

TYPED_TEST(GuardedKernels, PositionsAnywhereReadInside) {
  using T = TypeParam;
  this->watch([&] {
    for (const Size& s : kSizes)
      for (int64_t padding = 0; padding < 3; ++padding)
        for (int64_t mode = 0; mode < 3; ++mode)
          for (int32_t corners = 0; corners < 2; ++corners) {
            const Tensor source = this->numbers({2, 3, s.height, s.width}), fill = this->numbers({3}, 0, 1);
            // Positions beyond every side, also in a run that is read forwards, for which pixels are loaded
            // in groups of eight.
            Tensor x = this->numbers({2, 3, 37}, -5, double(s.width) + 4),
                   y = this->numbers({2, 3, 37}, -5, double(s.height) + 4);
            this->run(aoti_torch_cpu_remap, source, x, y, mode, padding, corners, fill);
            for (int64_t i = 0; i < 74; ++i) reinterpret_cast<T*>(x->data())[i] = T(i % 37) * T(s.width) / 37;
            std::fill_n(reinterpret_cast<T*>(y->data()), 74, T(s.height - 1));
            this->run(aoti_torch_cpu_remap, source, x, y, mode, padding, corners, fill);
            const Tensor matrix = this->numbers({2, 3, 3}, -1, 1);
            this->run(aoti_torch_cpu_warp_perspective, source, matrix, s.height, s.width + 1, mode, padding,
                      corners, fill);
            this->run(aoti_torch_cpu_warp_perspective, source,
                      kernel_calls::of<T>({2, 3, 3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}), s.height, s.width, mode,
                      padding, corners, fill);
          }
  });
}

TYPED_TEST(GuardedKernels, PatchesReadInsideTheirImages) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (const int64_t side : {1, 5, 16}) {
        // Two images in a row of pixels; the second ends at the row's end.
        const int64_t area = s.height * s.width, second = s.height > 1 ? s.height / 2 * s.width : s.width;
        const Tensor pixels = this->numbers({2, 2, area + second}),
                     frames = this->numbers({2, 3, 2, 3}, -20, 40);
        const Tensor start = kernel_calls::of<int64_t>({2, 3}, {0, area, area}),
                     width = kernel_calls::of<int64_t>({2, 3}, {s.width});
        const Tensor height =
            kernel_calls::of<int64_t>({2, 3}, {s.height, second / s.width, second / s.width});
        this->run(aoti_torch_cpu_extract_patches, pixels, start, height, width, frames, side);
      }
  });
}

TYPED_TEST(GuardedKernels, ResizingStaysInside) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (const Size& to : {Size{1, 1}, Size{2, 3}, Size{5, 17}, Size{s.height * 2, s.width * 2},
                             Size{(s.height + 1) / 2, (s.width + 1) / 2}, Size{7, 40}}) {
        const Tensor x = this->numbers({1, 2, s.height, s.width});
        for (int64_t filter = 0; filter < 3; ++filter)
          for (int32_t corners = 0; corners < 2; ++corners)
            for (int32_t antialias = 0; antialias < 2; ++antialias)
              this->run(aoti_torch_cpu_resize, x, to.height, to.width, filter, corners, antialias);
        for (const int64_t border : {0, 1, 3})
          for (int32_t before = 0; before < 2; ++before)
            this->run(aoti_torch_cpu_resize_blurred, x, this->numbers({5}), to.height, to.width, int32_t{0},
                      border, before);
      }
  });
}

TYPED_TEST(GuardedKernels, ConvolutionsStayInside) {
  constexpr double kLarge = std::numeric_limits<double>::infinity();
  this->watch([&] {
    for (const Size& s : kSizes)
      for (const int64_t side : {1, 3})
        for (const int64_t stride : {1, 2})
          // Channels, groups, outputs, panels
          for (const auto& [channels, groups, outputs, panels] :
               {std::array<int64_t, 4>{1, 1, 1, 1}, {3, 1, 17, 2}, {6, 2, 34, 4}})
            for (const int64_t begin : {0, 3})
              this->run(aoti_torch_cpu_packed_convolution, this->numbers({2, s.height, s.width, channels}),
                        this->numbers({panels, side, side, channels / groups, 16}, -1, 1),
                        this->numbers({outputs}, -1, 1), stride, int64_t{1}, begin, begin + 1, begin + 1,
                        int64_t{1}, s.height + 2, s.width, -kLarge, kLarge);
  });
}

TYPED_TEST(GuardedKernels, EachValueIsInABin) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor row = this->numbers({2, s.height * s.width});
      for (const int64_t bins : {1, 7, 256}) {
        const Tensor counts = this->run(aoti_torch_cpu_row_histograms, row, this->numbers({2, 1}, -1, 0),
                                        this->numbers({2, 1}, 1, 2), bins);
        int64_t counted = 0;
        for (int64_t i = 0; i < counts->numel(); ++i)
          counted += reinterpret_cast<const int32_t*>(counts->data())[i];
        EXPECT_EQ(counted, row->numel());  // NaN in the first one
      }
    }
  });
}

TYPED_TEST(GuardedKernels, FeaturesStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor margins = kernel_calls::of<int64_t>({4}, {0, 1, 2, 0});
      const Tensor places =
          this->run(aoti_torch_cpu_scale_space_nms, this->numbers({2, 4, s.height, s.width}, -1, 1), margins,
                    int32_t{1}, int64_t{9});
      for (int64_t i = 0; i < places->numel(); ++i) {
        const int64_t place = reinterpret_cast<const int64_t*>(places->data())[i];
        EXPECT_TRUE(place >= -1 && place < 4 * s.height * s.width);
      }
      const Tensor a = this->numbers({2, s.height, 5}), b = this->numbers({2, s.width, 5}, -1, 1);
      const Tensor distances = this->run(aoti_torch_cpu_cdist_squared, a, b);
      this->run(aoti_torch_cpu_two_smallest, distances, int32_t{0});
      this->run(aoti_torch_cpu_two_smallest, distances, int32_t{1});
    }
  });
}

TYPED_TEST(GuardedKernels, ShapesStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor x = this->numbers({2, s.height, s.width}, -0.5, 0.5);
      const Tensor numbers = this->run(aoti_torch_cpu_connected_components, x, false);
      for (int64_t i = 0; i < numbers->numel(); ++i)
        EXPECT_LE(reinterpret_cast<const uint64_t*>(numbers->data())[i], uint64_t(s.height * s.width));
      const Tensor mask = this->template wholes<uint8_t>({2, s.height, s.width}, 0, 1);
      for (const int64_t points : {3, 40}) this->run(aoti_torch_cpu_find_contours, mask, int64_t{5}, points);
    }
  });
}

TYPED_TEST(GuardedKernels, ModelsStayInside) {
  this->watch([&] {
    for (const int64_t n : {0, 1, 3, 4, 8, 9, 131})
      for (const int64_t count : {1, 3, 40})
        for (int32_t epipolar = 0; epipolar < 2; ++epipolar) {
          const Tensor best = this->run(aoti_torch_cpu_score_models, this->numbers({2, 17, 3, 3}, -1, 1),
                                        this->numbers({2, 7, n}), epipolar, count);
          for (int64_t i = 0; i < best->numel(); ++i)
            EXPECT_LT(reinterpret_cast<const uint64_t*>(best->data())[i], 17u);
        }
    if constexpr (std::is_same_v<TypeParam, double>) {
      for (int64_t n = 1; n <= 16; ++n)
        for (const int64_t count : {1, 3, 4, 5}) {
          this->run(aoti_torch_cpu_batched_inverse, this->numbers({count, n, n}, -1, 1));
          this->run(aoti_torch_cpu_weighted_grams, this->numbers({2, 13 * count, n}, -1, 1),
                    this->numbers({2, 13 * count, count}, -1, 1));
          this->run(aoti_torch_cpu_spd_inverse, this->numbers({count, n, n}, -1, 1));
          this->run(aoti_torch_cpu_normalized_power, this->numbers({count, n, n}, -1, 1), int64_t{5});
          this->run(aoti_torch_cpu_real_roots, this->numbers({n + 1, count}, -1, 1));
        }
    }
  });
}

TYPED_TEST(GuardedKernels, FallbacksStayInside) {
  this->watch([&] {
    for (const Dims& sizes : {Dims{1}, Dims{3, 0}, Dims{0, 3}, Dims{2, 7}, Dims{3, 1, 9}, Dims{2, 33, 5}}) {
      const Tensor x = this->numbers(sizes, -1, 1),
                   whole = this->template wholes<int64_t>(sizes, INT64_MIN, INT64_MAX);
      const auto ndim = static_cast<int64_t>(sizes.size());
      for (int64_t dim = -ndim; dim < ndim; ++dim)
        for (const Tensor* values : {&x, &whole}) {
          Handle sums = nullptr;
          EXPECT_EQ(aoti_torch_cpu_cumsum(values->get(), dim, nullptr, &sums), 0) << kernel_calls::last_error;
          delete sums;
        }
      for (int64_t k = 0; k <= sizes.back(); ++k)
        for (int32_t largest = 0; largest < 2; ++largest) {
          Handle values = nullptr, indices = nullptr;
          EXPECT_EQ(aoti_torch_cpu_topk(x.get(), k, -1, largest, 1, &values, &indices), 0)
              << kernel_calls::last_error;
          for (int64_t i = 0; i < indices->numel(); ++i)
            EXPECT_LT(reinterpret_cast<const uint64_t*>(indices->data())[i], uint64_t(sizes.back()));
          delete values;
          delete indices;
        }
    }
  });
}

// Integers have no special values, so there is one way to fill tensors.
constexpr std::initializer_list<Fill> kWhole = {Fill::kOrdinary};
using GuardedBytes = GuardedKernels<float>;

TEST_F(GuardedBytes, ShapesOfWindowsOfWholeNumbersStayInside) {
  watch(
      [&] {
        const auto all = [&](int64_t height, int64_t pixels, int64_t step, const auto& each) {
          const Dims sizes{2, height, pixels * step};
          each(wholes<uint8_t>(sizes, 0, 255), step);
          each(wholes<int16_t>(sizes, INT16_MIN, INT16_MAX), step);
          each(wholes<uint16_t>(sizes, 0, UINT16_MAX), step);
        };
        int64_t step = 1;
        for (const Size& s : kSizes)
          all(s.height, s.width, step = 4 - step,  // 3, 1, 3, ...
              [&](const Tensor& x, int64_t apart) { shapes_of_windows(x, apart); });
        all(3, 3001, 3, [&](const Tensor& x, int64_t apart) { wide_windows(x, apart); });
        for (int64_t border = 0; border < kBorders; ++border)
          run(aoti_torch_cpu_rank_of_bytes, wholes<uint8_t>({2, 3, 9003}, 0, 255), int64_t{3}, int64_t{3},
              int64_t{9}, int64_t{7}, border);
      },
      kWhole);
}

// Ratios, weights and orders that have loops of their own.
TEST_F(GuardedBytes, PixelsStayInside) {
  const auto bytes = [&](const Dims& sizes) { return wholes<uint8_t>(sizes, 0, 255); };
  // The four neighbours of each of `count` positions along `pixels` pixels.
  const auto neighbours = [](int64_t pixels, int64_t count) {
    std::vector<int64_t> numbers;
    for (int64_t i = 0; i < count; ++i)
      for (int64_t k = -1; k < 3; ++k)
        numbers.push_back(std::clamp<int64_t>(i * pixels / count + k, 0, pixels - 1));
    return kernel_calls::of<int64_t>({count, 4}, numbers);
  };
  const auto quarters = [&](int64_t count) { return wholes<int64_t>({count, 4}, -300, 2100); };
  const Tensor grey = kernel_calls::of<int32_t>({1, 4}, {9798, 19235, 3735, 16384}),
               colours =
                   kernel_calls::of<int32_t>({3, 4}, {4899, 9617, 1868, 8192, -2763, -5424, 8187, 2105344}),
               longer = kernel_calls::of<int32_t>({3, 4}, {40000, -33000, 12, 77, -39999, 1, 2, 3}),
               video = kernel_calls::of<int32_t>({6}, {1220542, 1673527, -409993, -852492, 2116026, 16}),
               encoded = kernel_calls::of<int32_t>(
                   {10}, {269484, 528482, 102760, -155188, -305135, 460324, 460324, -385875, -74448, 16}),
               orders[] = {kernel_calls::of<int32_t>({3}, {2, 1, 0}),
                           kernel_calls::of<int32_t>({4}, {0, 1, 2, -1}),
                           kernel_calls::of<int32_t>({2}, {9, 0})};
  watch(
      [&] {
        for (const Size& s : kSizes)
          for (const int64_t step : {1, 3, 4}) {
            const Tensor x = bytes({2, s.height, s.width * step});
            for (const Size& to : {Size{1, 1}, Size{s.height * 2, s.width * 2}, Size{7, 40}}) {
              run(aoti_torch_cpu_area_bytes, x, to.height, to.width, step);
              run(aoti_torch_cpu_resize_bytes, x, to.height, to.width, step, int32_t{0});
              run(aoti_torch_cpu_resize_nearest, x, to.height, to.width, step);
            }
            run(aoti_torch_cpu_resize_cubic_bytes, x, neighbours(s.height, 2 * s.height),
                quarters(2 * s.height), neighbours(s.width, 2 * s.width), quarters(2 * s.width), step);
            for (const Tensor& order : orders) {
              run(aoti_torch_cpu_arrange_pixels, bytes({2, s.height * s.width * step}), order, step, 7.0);
              run(aoti_torch_cpu_arrange_pixels, wholes<uint16_t>({2, s.width * step}, 0, 65535), order, step,
                  7.0);
            }
          }
        for (const Size& s : kSizes)
          for (const int32_t flag : {0, 1}) {
            const Tensor pixels = bytes({2, s.height * s.width * 3});
            for (const Size& part : {Size{s.height, s.width}, Size{(s.height + 1) / 2, (s.width + 1) / 2}}) {
              const Tensor luma = bytes({2, s.height, s.width}), u = bytes({2, part.height, part.width});
              run(aoti_torch_cpu_subsampled_pixels, luma, bytes({2, part.height, 2 * part.width}), video,
                  int32_t{0}, flag);
              run(aoti_torch_cpu_subsampled_planes, luma, u, u, video, flag);
            }
            for (const int32_t interleaved : {0, 1})
              run(aoti_torch_cpu_packed_pixels, bytes({2, s.height, 4 * s.width}), video, flag, interleaved);
            run(aoti_torch_cpu_nv12_pixels, pixels, encoded, s.height, flag);
            run(aoti_torch_cpu_mix_pixels, pixels, grey, int64_t{15}, flag);
            run(aoti_torch_cpu_mix_pixels, pixels, colours, int64_t{14}, flag);
            run(aoti_torch_cpu_mix_pixels, pixels, longer, int64_t{14}, flag);
          }
      },
      kWhole);
}

TEST_F(GuardedBytes, BilateralMeansStayInside) {
  const auto wide = [&](const Dims& sizes, int64_t high) {
    const Tensor whole = wholes<int32_t>(sizes, 0, high);
    Tensor tensor = kernel_calls::make(sizes, kCode<double>);
    std::copy_n(reinterpret_cast<const int32_t*>(whole->data()), whole->numel(),
                reinterpret_cast<double*>(tensor->data()));
    return tensor;
  };
  watch(
      [&] {
        for (const Size& s : kSizes)
          for (int64_t border = 0; border < kBorders; ++border) {
            const Tensor x = wholes<uint8_t>({2, 2, s.height, s.width}, 0, 255),
                         guide = wholes<uint8_t>({1, 3, s.height, s.width}, 0, 255);
            // Tables with all distances, and shorter ones.
            run(aoti_torch_cpu_bilateral_bytes, x, x, wide({1, 3, 5}, 65536), wide({1, 511}, 65536), border,
                int32_t{0});
            run(aoti_torch_cpu_bilateral_bytes, x, guide, wide({2, 5, 3}, 65536), wide({2, 195076}, 65536),
                border, int32_t{1});
            run(aoti_torch_cpu_bilateral_bytes, x, x, wide({1, 1, 1}, 65536), wide({1, 1}, 65536), border,
                int32_t{1});
          }
      },
      kWhole);
}

#include "guarded_calls.inc"

}  // namespace
