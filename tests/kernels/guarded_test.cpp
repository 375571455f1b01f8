// Calls every kernel like compiled ops do, with sizes that leave parts of vectors and strips, every border
// and special values, and with guards around every tensor. Other tests check the results; here a kernel must
// stay in its memory, give the same results wherever that is, and end.
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

template <class T>
class GuardedKernels : public ::testing::Test {
 protected:
  using Limits = std::numeric_limits<T>;

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

  T number(double low, double high) {
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

  Tensor numbers(const Dims& sizes, double low = 0, double high = 1) {
    Tensor tensor = kernel_calls::make(sizes, kCode<T>);
    seed(sizes, low, high);
    auto* const data = reinterpret_cast<T*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i) data[i] = number(low, high);
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

  Tensor doubles(const Dims& sizes) {
    Tensor tensor = kernel_calls::make(sizes, kDouble);
    seed(sizes, 0, 1);
    auto* const data = reinterpret_cast<double*>(tensor->data());
    for (int64_t i = 0; i < tensor->numel(); ++i) data[i] = static_cast<double>(number(0, 1));
    return tensor;
  }

  // For images (N, H, L) from `make`: small and large boxes, a few pixels, and a disk, all with an anchor
  // outside the centre.
  template <class Make>
  void extremes_and_medians(const Make& make, int64_t step) {
    const Tensor x = make();
    for (int64_t border = 0; border < kBorders; ++border) {
      for (const int64_t size : {1, 3, 9, 33})
        run(aoti_torch_cpu_minmax_filter, x, step, int64_t{5}, size, border, 0.5, int32_t{1});
      run(aoti_torch_cpu_minmax_filter, x, step, int64_t{9}, int64_t{3}, border, 0.5, int32_t{0});
      const Tensor few = kernel_calls::of<double>({3, 2}, {0, -1e4, -1e4, 0, 0, 0}),
                   disk = kernel_calls::of<double>(
                       {5, 4}, {-1e4, 0, 0, -1e4, 0, 0, 0, 0, 0, 0, 0, -1e4, 0, 0, 0, 0, -1e4, 0, -1e4, 0}),
                   box = kernel_calls::of<double>({2, 3}, {-1e4, 0, 0});
      for (const Tensor* window : {&few, &disk, &box}) {
        run(aoti_torch_cpu_morphology, x, step, *window, int64_t{0}, int64_t{0}, border, 0.5, 1e4,
            int32_t{1});
        run(aoti_torch_cpu_morphology_gradient, x, step, *window, *window, int64_t{1}, int64_t{1}, border,
            0.5, 0.25, 1e4);
      }
      for (const int64_t size : {3, 5, 7}) run(aoti_torch_cpu_median_filter, x, step, size, border);
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
      known_->see(*tensor, !is_inexact(call)          ? Results::kExact
                           : fill_ == Fill::kOrdinary ? Results::kRounded
                                                      : Results::kAny);
    return tensor;
  }

  // Calls whose sums, exponentials or angles depend on the vector length or on a library, so huge numbers may
  // or may not overflow.
  template <class Function>
  static bool is_inexact(Function* call) {
    const auto is = [&](auto* other) {
      return reinterpret_cast<void (*)()>(call) == reinterpret_cast<void (*)()>(other);
    };
    return is(aoti_torch_cpu_bilateral) || is(aoti_torch_cpu_orientation_histograms) ||
           is(aoti_torch_cpu_resize) || is(aoti_torch_cpu_resampled) || is(aoti_torch_cpu_resize_blurred) ||
           is(aoti_torch_cpu_integral) || is(aoti_torch_cpu_cdist_squared) ||
           is(aoti_torch_cpu_two_smallest) || is(aoti_torch_cpu_grown_distances) ||
           is(aoti_torch_cpu_packed_convolution) || is(aoti_torch_cpu_depthwise_convolution);
  }

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

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(GuardedKernels, Types);

TYPED_TEST(GuardedKernels, WindowsStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (int64_t border = 0; border < kBorders; ++border) {
        const Tensor x = this->numbers({2, 1, s.height, s.width});
        for (const int64_t size : {1, 3, 9}) {
          this->run(aoti_torch_cpu_separable, x, this->numbers({1, size}), this->numbers({2, 5}), border, 2.0,
                    -1.0);
          this->run(aoti_torch_cpu_correlate2d, x, this->numbers({1, 2, size}), border);
          this->run(aoti_torch_cpu_correlate2d, x, this->numbers({2, size, 4}), border);
        }
        this->run(aoti_torch_cpu_correlate2d, this->numbers({0, 2, s.height, s.width}),
                  this->numbers({0, 3, 3}), border);
      }
  });
}

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

TYPED_TEST(GuardedKernels, ExtremesAndMediansStayInside) {
  this->watch([&] {
    int64_t step = 1;
    for (const Size& s : kSizes) {
      step = 4 - step;  // 3, 1, 3, ...
      this->extremes_and_medians([&] { return this->numbers({2, s.height, s.width * step}); }, step);
    }
    this->extremes_and_medians([&] { return this->numbers({1, 3, 12000}); }, 3);
    for (int64_t border = 0; border < kBorders; ++border) {
      const Tensor x = this->numbers({1, 9, 17}), high = this->doubles({3, 5}), low = this->doubles({3, 5});
      this->run(aoti_torch_cpu_morphology, x, int64_t{1}, high, int64_t{2}, int64_t{4}, border, 0.5, 1e4,
                int32_t{0});
      this->run(aoti_torch_cpu_morphology_gradient, x, int64_t{1}, high, low, int64_t{0}, int64_t{2}, border,
                0.5, 0.25, 1e4);
    }
  });
}

TYPED_TEST(GuardedKernels, BilateralStaysInside) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (int64_t border = 0; border < kBorders; ++border) {
        const Tensor x = this->numbers({2, 2, s.height, s.width}),
                     guide = this->numbers({1, 3, s.height, s.width});
        this->run(aoti_torch_cpu_bilateral, x, x, this->numbers({1, 3, 5}), this->numbers({1}, -5, 0), border,
                  int32_t{0});
        this->run(aoti_torch_cpu_bilateral, x, guide, this->numbers({2, 5, 3}), this->numbers({2}, -5, 0),
                  border, int32_t{1});
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
            const Tensor source = this->numbers({2, 3, s.height, s.width});
            // Positions beyond every side, also in a run that is read forwards, for which pixels are loaded
            // in groups of eight.
            Tensor x = this->numbers({2, 3, 37}, -5, double(s.width) + 4),
                   y = this->numbers({2, 3, 37}, -5, double(s.height) + 4);
            this->run(aoti_torch_cpu_remap, source, x, y, mode, padding, corners);
            for (int64_t i = 0; i < 74; ++i) reinterpret_cast<T*>(x->data())[i] = T(i % 37) * T(s.width) / 37;
            std::fill_n(reinterpret_cast<T*>(y->data()), 74, T(s.height - 1));
            this->run(aoti_torch_cpu_remap, source, x, y, mode, padding, corners);
            const Tensor matrix = this->numbers({2, 3, 3}, -1, 1);
            this->run(aoti_torch_cpu_warp_perspective, source, matrix, s.height, s.width + 1, mode, padding,
                      corners);
            this->run(aoti_torch_cpu_warp_perspective, source,
                      kernel_calls::of<T>({2, 3, 3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}), s.height, s.width, mode,
                      padding, corners);
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
        this->run(aoti_torch_cpu_resampled, x, this->template wholes<int64_t>({to.height, 3}, -2, s.height),
                  this->numbers({to.height, 3}),
                  this->template wholes<int64_t>({to.width, 2}, INT64_MIN, INT64_MAX),
                  this->numbers({to.width, 2}));
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
        for (const int64_t stride : {1, 2}) {
          const auto call = [&](auto* function, const Tensor& x, const Tensor& weight, const Tensor& bias,
                                int64_t begin, int64_t apart, int64_t height, int64_t width, double low) {
            this->run(function, x, weight, bias, stride, int64_t{1}, begin, begin + 1, apart, int64_t{1},
                      height, width, low, kLarge);
          };
          // Channels, groups, outputs, panels
          for (const auto& [channels, groups, outputs, panels] :
               {std::array<int64_t, 4>{1, 1, 1, 1}, {3, 1, 17, 2}, {6, 2, 34, 4}})
            for (const int64_t begin : {0, 3})
              call(aoti_torch_cpu_packed_convolution, this->numbers({2, s.height, s.width, channels}),
                   this->numbers({panels, side, side, channels / groups, 16}, -1, 1),
                   this->numbers({outputs}, -1, 1), begin, begin + 1, s.height + 2, s.width, -kLarge);
          for (const int64_t channels : {1, 5, 37})
            call(aoti_torch_cpu_depthwise_convolution, this->numbers({1, s.height, s.width, channels}),
                 this->numbers({side, side, channels}, -1, 1), this->numbers({channels}, -1, 1), 1, 2,
                 (s.height + 1) / stride, s.width + 2, 0);
        }
  });
}

TYPED_TEST(GuardedKernels, SumsLevelsAndEdgesStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor x = this->numbers({2, 1, s.height, s.width}), row = this->numbers({2, s.height * s.width});
      this->run(aoti_torch_cpu_integral, x);
      this->run(aoti_torch_cpu_mirrored, this->numbers({2, s.height, s.width}), int64_t{1}, int32_t{1},
                int32_t{1});
      this->run(aoti_torch_cpu_quantize_u8, x);
      this->run(aoti_torch_cpu_sobel, x, 0.125, 1e-6);
      this->run(aoti_torch_cpu_canny_nms, x, 1e-6);
      this->run(aoti_torch_cpu_canny_hysteresis, x, 0.2, 0.6);
      const Tensor extents = this->run(aoti_torch_cpu_aminmax, row);
      for (const int64_t bins : {1, 7, 256}) {
        const Tensor counts = this->run(aoti_torch_cpu_row_histograms, row, this->numbers({2, 1}, -1, 0),
                                        this->numbers({2, 1}, 1, 2), bins);
        int64_t counted = 0;
        for (int64_t i = 0; i < counts->numel(); ++i)
          counted += reinterpret_cast<const int32_t*>(counts->data())[i];
        EXPECT_EQ(counted, row->numel());  // each value is in a bin, NaN in the first one
      }
      this->run(aoti_torch_cpu_lut, this->numbers({2, 256}),
                this->template wholes<uint8_t>({2, s.height * s.width}, 0, 255));
    }
  });
}

TYPED_TEST(GuardedKernels, FeaturesStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor margins = kernel_calls::of<int64_t>({4}, {0, 1, 2, 0});
      for (const int64_t most : {0, 3, 1000})
        this->run(aoti_torch_cpu_kept_boxes, this->numbers({2, s.height * s.width, 4}, 0, 9),
                  this->template wholes<int64_t>({2, s.height * s.width}, -1, 1), 0.25, most);
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
      if (s.width < 40) {
        const Tensor patches = this->numbers({3, s.width, s.width}),
                     window = this->numbers({s.width, s.width});
        for (const int64_t bins : {1, 8, 36})
          this->run(aoti_torch_cpu_orientation_histograms, patches, window, this->numbers({4, s.width}),
                    bins);
      }
    }
  });
}

TYPED_TEST(GuardedKernels, ShapesStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor x = this->numbers({2, s.height, s.width}, -0.5, 0.5);
      this->run(aoti_torch_cpu_euclidean_distances, x);
      const Tensor numbers = this->run(aoti_torch_cpu_connected_components, x);
      for (int64_t i = 0; i < numbers->numel(); ++i)
        EXPECT_LE(reinterpret_cast<const uint64_t*>(numbers->data())[i], uint64_t(s.height * s.width));
      const Tensor mask = this->template wholes<uint8_t>({2, s.height, s.width}, 0, 1);
      for (const int64_t points : {3, 40}) this->run(aoti_torch_cpu_outlines, mask, int64_t{5}, points);
      for (int32_t zhang = 0; zhang < 2; ++zhang) this->run(aoti_torch_cpu_thinned, x, int64_t{99}, zhang);
      for (const int64_t taps : {1, 3, 5})
        this->run(aoti_torch_cpu_grown_distances, x, this->numbers({taps, taps}), 0.35, int64_t{20});
      for (const Size& window : {Size{3, 3}, Size{1, 4}, Size{6, 5}})
        for (int32_t largest = 0; largest < 2; ++largest) {
          // A caller's bools may have any byte values.
          Tensor element = this->template wholes<uint8_t>({window.height, window.width}, 0, 3);
          element->dtype = kBool;
          this->run(aoti_torch_cpu_reconstructed, x, this->numbers({2, s.height, s.width}), element, 0.25,
                    largest);
        }
    }
  });
}

TYPED_TEST(GuardedKernels, PaintStaysInside) {
  this->watch([&] {
    for (const Size& s : kSizes) {
      const Tensor image = this->numbers({2, 3, s.height, s.width}),
                   bytes = this->template wholes<uint8_t>({2, 3, s.height, s.width}, 0, 255);
      const auto places = [&](const Dims& sizes) { return this->template wholes<int64_t>(sizes, -9, 40); };
      const auto anywhere = [&](const Dims& sizes) {
        return this->template wholes<int64_t>(sizes, INT64_MIN, INT64_MAX);
      };
      for (int32_t fill = 0; fill < 2; ++fill) {
        this->run(aoti_torch_cpu_draw_rectangles, image, places({2, 5, 4}), this->numbers({2, 3, 5}),
                  int64_t{2}, int64_t{1}, fill);
        this->run(aoti_torch_cpu_draw_rectangles, bytes, anywhere({2, 5, 4}),
                  this->template wholes<uint8_t>({2, 3, 5}, 0, 255), int64_t{0}, int64_t{INT32_MAX}, fill);
      }
      this->run(aoti_torch_cpu_fill_spans, image, places({2, 2, s.height}), places({2, 2, s.height}),
                this->numbers({2, 3}));
      this->run(aoti_torch_cpu_fill_spans, bytes, anywhere({2, 1, s.height}), anywhere({2, 1, s.height}),
                this->template wholes<uint8_t>({2, 3}, 0, 255));
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

TEST_F(GuardedBytes, ExtremesAndMediansOfWholeNumbersStayInside) {
  watch(
      [&] {
        const auto all = [&](int64_t height, int64_t pixels, int64_t step) {
          const Dims sizes{2, height, pixels * step};
          extremes_and_medians([&] { return wholes<uint8_t>(sizes, 0, 255); }, step);
          extremes_and_medians([&] { return wholes<int16_t>(sizes, INT16_MIN, INT16_MAX); }, step);
          extremes_and_medians([&] { return wholes<uint16_t>(sizes, 0, UINT16_MAX); }, step);
          for (int64_t border = 0; border < kBorders; ++border)
            for (const int64_t rank : {0, 7, 26})
              run(aoti_torch_cpu_rank_of_bytes, wholes<uint8_t>(sizes, 0, 255), step, int64_t{3}, int64_t{9},
                  rank, border);
        };
        int64_t step = 1;
        for (const Size& s : kSizes) all(s.height, s.width, step = 4 - step);  // 3, 1, 3, ...
        all(3, 3001, 3);
      },
      kWhole);
}

TEST_F(GuardedBytes, PixelsStayInside) {
  const auto bytes = [&](const Dims& sizes) { return wholes<uint8_t>(sizes, 0, 255); };
  const Tensor three = kernel_calls::of<int32_t>({1, 3}, {128, 50, 14}),
               one = kernel_calls::of<int32_t>({1, 1}, {256});
  // Indices in and around `pixels` pixels, and taps with a sum of about 1.
  const auto numbers_of = [&](int64_t pixels, int64_t count, int64_t taps) {
    return wholes<int64_t>({count, taps}, -2, pixels + 1);
  };
  // The four neighbours of each of `count` positions along `pixels` pixels.
  const auto neighbours = [](int64_t pixels, int64_t count) {
    std::vector<int64_t> numbers;
    for (int64_t i = 0; i < count; ++i)
      for (int64_t k = -1; k < 3; ++k)
        numbers.push_back(std::clamp<int64_t>(i * pixels / count + k, 0, pixels - 1));
    return kernel_calls::of<int64_t>({count, 4}, numbers);
  };
  const auto weights = [&](int64_t count, int64_t taps) {
    return wholes<int32_t>({count, taps}, -200000, 5000000 / static_cast<int32_t>(taps));
  };
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
            const Tensor x = bytes({2, s.height, s.width * step}),
                         row = bytes({2, s.height * s.width * step});
            for (int64_t border = 0; border < kBorders; ++border) {
              run(aoti_torch_cpu_separable_bytes, x, three, three, step, border);
              run(aoti_torch_cpu_separable_bytes, x, one, three, step, border);
              for (const Size& window : {Size{1, 1}, Size{2, 5}, Size{5, 3}})
                run(aoti_torch_cpu_correlate_bytes, x,
                    kernel_calls::of<float>({2, window.height, window.width}, {3, 0, -8, 77, -5}),
                    kernel_calls::of<float>({2}, {0.5f, 0.125f}), step, border);
              for (const Size& window : {Size{1, 1}, Size{2, 5}, Size{20, 70}})
                run(aoti_torch_cpu_box_bytes, x, window.height, window.width, step, border);
              for (const Size& window : {Size{1, 1}, Size{3, 5}, Size{1, 129}})
                run(aoti_torch_cpu_laplacian_bytes, x, window.height, window.width, step, border);
            }
            run(aoti_torch_cpu_integral_bytes, x, step);
            run(aoti_torch_cpu_moments_bytes, row);
            for (const int32_t greatest : {0, 1}) {
              run(aoti_torch_cpu_extreme_index, row, greatest);
              run(aoti_torch_cpu_extreme_index, numbers({2, s.height * s.width * step}), greatest);
            }
            for (const int64_t far : {int64_t{12}, INT64_MAX}) {
              const auto places = [&](int64_t bins) { return wholes<int64_t>({3, bins}, -far, far); };
              const Tensor which = wholes<int64_t>({3}, -far, far), rows[] = {places(2), places(2)},
                           columns[] = {places(3), places(3)};
              run(aoti_torch_cpu_box_maxima, numbers({2, 2, s.height, s.width}), which, rows[0], rows[1],
                  columns[0], columns[1]);
              run(aoti_torch_cpu_box_means, numbers({2, 1, 6, s.height, s.width}), which, rows[0], rows[1],
                  columns[0], columns[1]);
            }
            run(aoti_torch_cpu_split_pixels, row, step);
            run(aoti_torch_cpu_join_pixels, row, step);
            run(aoti_torch_cpu_lut_bytes, bytes({1, 256}), row);
            for (const Size& to : {Size{1, 1}, Size{5, 17}, Size{s.height * 2, s.width * 2}, Size{7, 40}}) {
              run(aoti_torch_cpu_area_bytes, x, to.height, to.width, step);
              run(aoti_torch_cpu_resize_bytes, x, to.height, to.width, step, int32_t{0});
              run(aoti_torch_cpu_resize_bytes, x, to.height, to.width, step, int32_t{1});
              run(aoti_torch_cpu_resize_nearest, x, to.height, to.width, step);
              run(aoti_torch_cpu_resize_nearest, numbers({2, s.height, s.width * step}), to.height, to.width,
                  step);
            }
            const Tensor places = wholes<int64_t>({3, 8}, -9, 40),
                         anywhere = wholes<int64_t>({3, 8}, INT64_MIN, INT64_MAX),
                         which = kernel_calls::of<int64_t>({3}, {1, 0, 1});
            for (const Tensor* boxes : {&places, &anywhere})
              run(aoti_torch_cpu_placed_bytes, x, which, *boxes, int64_t{7}, int64_t{33}, step, int64_t{9});
            for (const int32_t interleaved : {0, 1})
              run(aoti_torch_cpu_scaled_bytes, row, kernel_calls::of<int32_t>({3}, {0, 9, -1}),
                  kernel_calls::of<float>({3, 2}, {0.5f, 1, -2, 3, 4, 5}), step, interleaved);
            for (const int64_t taps : {1, 6})
              run(aoti_torch_cpu_resample_bytes, x, numbers_of(s.height, 7, taps), weights(7, taps),
                  numbers_of(s.width, 9, taps), weights(9, taps), step);
            const auto quarters = [&](int64_t count) { return wholes<int64_t>({count, 4}, -300, 2100); };
            run(aoti_torch_cpu_resize_cubic_bytes, x, numbers_of(s.height, 7, 4), quarters(7),
                numbers_of(s.width, 9, 4), quarters(9), step);
            run(aoti_torch_cpu_resize_cubic_bytes, x, neighbours(s.height, 2 * s.height),
                quarters(2 * s.height), neighbours(s.width, 2 * s.width), quarters(2 * s.width), step);
            for (const int32_t along : {0, 1}) {
              run(aoti_torch_cpu_mirrored, x, step, along, int32_t{1});
              run(aoti_torch_cpu_mirrored, wholes<int16_t>({2, s.height, s.width * step}, -9, 9), step, along,
                  int32_t{0});
            }
            for (int64_t border = 0; border < kBorders; ++border)
              run(aoti_torch_cpu_pyramid_down_bytes, x, step, border);
            run(aoti_torch_cpu_pyramid_up_bytes, x, step);
            const Tensor other = bytes({2, s.height * s.width * step}), mask = bytes({2, s.height * s.width}),
                         low = wholes<int32_t>({2, step}, -5, 130),
                         high = wholes<int32_t>({2, step}, 100, 256);
            run(aoti_torch_cpu_subtract_pixels, row, other);
            run(aoti_torch_cpu_weighted_bytes, row, other,
                kernel_calls::of<float>({1, 3}, {0.75f, -0.5f, 9.0f}));
            for (const int32_t interleaved : {0, 1}) {
              run(aoti_torch_cpu_range_mask, row, low, high, interleaved);
              run(aoti_torch_cpu_masked_pixels, row, mask, interleaved);
            }
            run(aoti_torch_cpu_sobel_derivatives, x);
            run(aoti_torch_cpu_sobel_bytes, x, step, 0.125);
            for (const int32_t flag : {0, 1}) {
              for (const Size& part : {Size{s.height, s.width}, Size{(s.height + 1) / 2, (s.width + 1) / 2}})
                for (const int32_t interleaved : {0, 1})
                  run(aoti_torch_cpu_subsampled_pixels, bytes({2, s.height, s.width}),
                      bytes({2, part.height, 2 * part.width}), video, flag, interleaved);
              run(aoti_torch_cpu_packed_pixels, bytes({2, s.height, 4 * s.width}), video, flag);
            }
            const Tensor pixels = bytes({2, s.height * s.width * 3});
            for (const int32_t interleaved : {0, 1}) {
              run(aoti_torch_cpu_nv12_pixels, pixels, encoded, s.height, interleaved);
              for (int64_t red = 0; red < 4 && s.height > 1 && s.width > 1; ++red) {
                run(aoti_torch_cpu_demosaiced, bytes({2, s.height, s.width}), red / 2, red % 2, interleaved);
                run(aoti_torch_cpu_demosaiced, wholes<uint16_t>({2, s.height, s.width}, 0, UINT16_MAX),
                    red / 2, red % 2, interleaved);
              }
              run(aoti_torch_cpu_mix_pixels, pixels, grey, int64_t{15}, interleaved);
              run(aoti_torch_cpu_mix_pixels, pixels, colours, int64_t{14}, interleaved);
              run(aoti_torch_cpu_mix_pixels, pixels, longer, int64_t{14}, interleaved);
              run(aoti_torch_cpu_luma_chroma_pixels, pixels, int64_t{4899}, int64_t{9617}, int64_t{1868},
                  int64_t{8061}, int64_t{14369}, interleaved);
              for (const int64_t lasts : {1, 200})
                run(aoti_torch_cpu_curve_pixels, pixels, wholes<int32_t>({3, 256}, 0, 500), longer,
                    wholes<int32_t>({300}, 0, 900), longer, wholes<int32_t>({lasts}, 0, 255), int64_t{3},
                    int64_t{9}, interleaved);
              for (const int32_t lightness : {0, 1}) {
                run(aoti_torch_cpu_hue_pixels, pixels, lightness, interleaved);
                run(aoti_torch_cpu_from_hue_pixels, pixels, lightness, interleaved);
              }
            }
            for (const Tensor& order : orders) {
              run(aoti_torch_cpu_arrange_pixels, row, order, step, 7.0);
              run(aoti_torch_cpu_arrange_pixels, wholes<uint16_t>({2, s.width * step}, 0, 65535), order, step,
                  7.0);
            }
          }
      },
      kWhole);
}

// Tables with special values.
TEST_F(GuardedBytes, LuvStaysInside) {
  watch([&] {
    for (const Size& s : kSizes)
      for (const int32_t interleaved : {0, 1}) {
        const Tensor pixels = wholes<uint8_t>({2, s.height * s.width * 3}, 0, 255);
        run(aoti_torch_cpu_luv_pixels, pixels, doubles({256}), doubles({3, 3}), doubles({77}), interleaved);
        run(aoti_torch_cpu_from_luv_pixels, pixels, doubles({256}), doubles({256}), doubles({3, 3}),
            wholes<uint8_t>({77}, 0, 255), 1e-12, interleaved);
      }
  });
}

// Positions with special values.
TYPED_TEST(GuardedKernels, BytesAtPositionsStayInside) {
  this->watch([&] {
    for (const Size& s : kSizes)
      for (const int64_t step : {1, 2, 3, 4}) {
        const Tensor x = this->template wholes<uint8_t>({2, s.height, s.width * step}, 0, 255);
        const auto at = [&](int64_t size) { return this->numbers({2, 5, 37}, -3, double(size) + 3); };
        for (int64_t mode = 0; mode < 3; ++mode)
          for (int64_t padding = 0; padding < 3; ++padding)
            for (const int32_t corners : {0, 1}) {
              this->run(aoti_torch_cpu_remap_bytes, x, at(s.width), at(s.height), step, mode, padding,
                        corners);
              if constexpr (std::is_same_v<TypeParam, double>)
                this->run(aoti_torch_cpu_warp_bytes, x, this->numbers({1, 3, 3}, -1, 2), s.height + 1,
                          s.width + 40, step, mode, padding, corners);
            }
      }
  });
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

TEST_F(GuardedBytes, FramesLevelsAndMasksStayInside) {
  watch([&] {
    for (const Size& s : kSizes) {
      if (s.width > 1) {
        const Tensor frame = wholes<uint8_t>({s.height, s.width, 3}, 0, 255);
        run(aoti_torch_cpu_frame_to_grey, frame);
        for (const int64_t to : {1, 3, 19}) run(aoti_torch_cpu_resize_frame, frame, to + 1, to);
      }
      const Tensor levels = wholes<uint8_t>({2, s.height, s.width}, 0, 255);
      for (const Size& tile : {Size{1, 1}, Size{3, 2}, Size{8, 9}})
        run(aoti_torch_cpu_clahe_histograms, levels, tile.height, tile.width,
            (s.height + tile.height - 1) / tile.height, (s.width + 2 * tile.width) / tile.width);
      const Tensor table = numbers({2, 6, 256}, 0, 255);
      const auto places = [&](int64_t n, int64_t last) { return wholes<int64_t>({n}, 0, last); };
      run(aoti_torch_cpu_clahe_interpolate, table, int64_t{3}, levels, places(s.height, 1),
          places(s.height, 1), numbers({s.height}), places(s.width, 2), places(s.width, 2),
          numbers({s.width}));
      for (const int64_t bins : {1, 9, 256}) {
        run(aoti_torch_cpu_bincount, wholes<uint8_t>({2, s.height * s.width}, 0, 255), bins);
        run(aoti_torch_cpu_bincount, wholes<int32_t>({2, s.height * s.width}, INT32_MIN, INT32_MAX), bins);
      }
    }
  });
}

}  // namespace
