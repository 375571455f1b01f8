// The kernels of key points, patches and descriptors, against their definitions in plain loops of doubles and
// against OpenCV.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

template <class T>
class FeatureKernels : public KernelsTest<T> {
 protected:
  FeatureKernels() : KernelsTest<T>(23) {}
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(FeatureKernels, Types);

TYPED_TEST(FeatureKernels, ScaleSpaceNmsMatchesPlainLoops) {
  using T = TypeParam;
  for (const Images& v : {Images{1, 3, 3, 3}, Images{2, 3, 9, 7}, Images{1, 5, 24, 45}, Images{1, 2, 9, 9}})
    for (const bool minima : {false, true})
      for (const int64_t count : {1, 7, 400}) {
        const int64_t plane = v.height * v.width;
        auto x = this->random(v.count * v.channels * plane, -1, 1);
        for (T& value : x) value = std::round(value * 20) / 20;  // with ties
        const std::vector<int64_t> margins{0, 0, 1, 3, 0};
        std::vector<int64_t> out(static_cast<size_t>(v.count * count));
        scale_space_nms(x.data(), v, margins.data(), minima, count, out.data());
        for (int64_t b = 0; b < v.count; ++b) {
          const T* const volume = x.data() + b * v.channels * plane;
          std::vector<std::pair<T, int64_t>> expected;
          for (int64_t l = 1; l + 1 < v.channels; ++l)
            for (int64_t r = 1; r + 1 < v.height; ++r)
              for (int64_t c = 1; c + 1 < v.width; ++c) {
                const int64_t m = margins[size_t(l)], at = l * plane + r * v.width + c;
                if (r < m || c < m || r >= v.height - m || c >= v.width - m) continue;
                bool most = volume[at] > 0, least = minima && volume[at] < 0;
                for (int64_t i = 0; i < 27; ++i) {
                  const int64_t other = at + (i / 9 - 1) * plane + (i / 3 % 3 - 1) * v.width + i % 3 - 1;
                  most = most && (other == at || volume[at] > volume[other]);
                  least = least && (other == at || volume[at] < volume[other]);
                }
                if (most || least) expected.emplace_back(-std::abs(volume[at]), at);
              }
          std::sort(expected.begin(), expected.end());
          for (int64_t k = 0; k < count; ++k)
            ASSERT_EQ(out[size_t(b * count + k)],
                      k < int64_t(expected.size()) ? expected[size_t(k)].second : -1)
                << v.height << "x" << v.width << ", slot " << k;
        }
      }
}

KERNEL_CALL_BENCHMARK(scale_space_nms, [] {
  return [x = kernel_benchmarks::random(5 * 480 * 640, -1, 1), margins = std::vector<int64_t>(5, 8),
          out = std::vector<int64_t>(2000)]() mutable {
    scale_space_nms(x.data(), {1, 5, 480, 640}, margins.data(), true, 2000, out.data());
  };
});

TYPED_TEST(FeatureKernels, CdistSquaredMatchesOpenCv) {
  using T = TypeParam;
  for (const auto& [rows, columns, depth] :
       {std::array<int, 3>{1, 1, 1}, {5, 13, 128}, {9, 24, 3}, {4, 12, 64}})
    for (const int64_t batch : {1, 2}) {
      auto a = this->random(batch * rows * depth, -1, 1), b = this->random(batch * columns * depth, -1, 1);
      for (auto* x : {&a, &b}) std::fill(x->begin() + int64_t(x->size()) / 2, x->end(), T(0));
      std::vector<T> out(static_cast<size_t>(batch * rows * columns));
      cdist_squared(a.data(), batch, rows, depth, b.data(), columns, out.data());
      for (int64_t i = 0; i < batch; ++i)
        for (int r = 0; r < rows; ++r)
          for (int c = 0; c < columns; ++c) {
            const cv::Mat left(1, depth, cv::DataType<T>::type,
                               const_cast<T*>(a.data() + (i * rows + r) * depth)),
                right(1, depth, cv::DataType<T>::type, const_cast<T*>(b.data() + (i * columns + c) * depth));
            ASSERT_NEAR(out[size_t((i * rows + r) * columns + c)], cv::norm(left, right, cv::NORM_L2SQR),
                        1e-5 * depth);
          }
    }
}

KERNEL_CALL_BENCHMARK(cdist_squared, [] {
  return [x = kernel_benchmarks::random(2000 * 128), out = std::vector<float>(2000 * 2000)]() mutable {
    cdist_squared(x.data(), 1, 2000, 128, x.data(), 2000, out.data());
  };
});

TYPED_TEST(FeatureKernels, TwoSmallestAreTheFirstOfTheSorted) {
  using T = TypeParam;
  constexpr T kInfinity = std::numeric_limits<T>::infinity();
  for (const Planes& p : {Planes{1, 1, 1}, Planes{2, 5, 3}, Planes{1, 40, 300}})
    for (const bool along_rows : {true, false}) {
      auto x = this->random(p.count * p.height * p.width, 0, 1);
      for (T& v : x) v = v > T(0.8) ? kInfinity : std::round(v * 10) / 10;
      if (x.size() > 1) x[1] = std::numeric_limits<T>::quiet_NaN();
      const int64_t lines = along_rows ? p.height : p.width, length = along_rows ? p.width : p.height;
      std::vector<int64_t> out(static_cast<size_t>(p.count * lines * 2));
      two_smallest(x.data(), p.count, p.height, p.width, along_rows, out.data());
      for (int64_t i = 0; i < p.count * lines; ++i) {
        std::vector<std::pair<T, int64_t>> line;
        for (int64_t k = 0; k < length; ++k) {
          const T value = x[size_t(i / lines * p.height * p.width +
                                   (along_rows ? i % lines * p.width + k : k * p.width + i % lines))];
          if (value < kInfinity) line.emplace_back(value, k);
        }
        std::sort(line.begin(), line.end());
        for (size_t k = 0; k < 2; ++k)
          ASSERT_EQ(out[size_t(2 * i) + k], k < line.size() ? line[k].second : -1);
      }
    }
}

TYPED_TEST(FeatureKernels, KeptBoxesMatchPlainLoops) {
  using T = TypeParam;
  for (const int64_t n : {0, 1, 2, 40, 300})
    for (const int64_t groups : {1, 4})
      for (const T threshold : {T(0), T(0.25), T(0.5)})
        for (const int64_t most : {int64_t{0}, int64_t{5}, n}) {
          // Integers, so that all products are exact; some boxes are empty or inverted.
          auto boxes = this->random(2 * n * 4, 0, 40);
          for (size_t i = 0; i < boxes.size(); ++i)
            boxes[i] = std::round(boxes[i]) + (i % 4 >= 2 && i % 28 != 2 ? T(15) : T(0));
          if (n > 2) boxes[5] = std::numeric_limits<T>::quiet_NaN();
          std::vector<int64_t> group(static_cast<size_t>(2 * n));
          for (size_t i = 0; i < group.size(); ++i)
            group[i] = static_cast<int64_t>(i * 7 % static_cast<size_t>(groups)) * 10000000000 - 5;
          const auto kept = std::make_unique<bool[]>(static_cast<size_t>(2 * n));
          nms(boxes.data(), 2, n, group.data(), threshold, most, kept.get());
          for (int64_t image = 0; image < 2; ++image) {
            int64_t chosen = 0;
            for (int64_t i = 0; i < n; ++i) {
              const T* const a = boxes.data() + 4 * (image * n + i);
              bool expected = chosen < most;
              for (int64_t j = 0; expected && j < i; ++j) {
                if (!kept[size_t(image * n + j)] ||
                    group[size_t(image * n + i)] != group[size_t(image * n + j)])
                  continue;
                const T* const b = boxes.data() + 4 * (image * n + j);
                const auto side = [&](int64_t k) {
                  return std::max<double>(0, double(std::min(a[k + 2], b[k + 2])) - std::max(a[k], b[k]));
                };
                const bool known = std::none_of(a, a + 4, [](T x) { return std::isnan(x); }) &&
                                   std::none_of(b, b + 4, [](T x) { return std::isnan(x); });
                const auto area = [](const T* x) { return (double(x[2]) - x[0]) * (double(x[3]) - x[1]); };
                const double common = side(0) * side(1);
                if (known && common > threshold * (area(a) + area(b) - common)) expected = false;
              }
              chosen += expected;
              ASSERT_EQ(kept[size_t(image * n + i)], expected) << i << " of " << n;
            }
          }
        }
}

// Like a detector's boxes: clusters around 300 objects.
KERNEL_CALL_BENCHMARK(nms, [] {
  constexpr int64_t kCount = 8400;
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> draw(0, 1);
  std::vector<float> boxes;
  for (int64_t i = 0; i < kCount; ++i) {
    const auto thing = static_cast<float>(i * 37 % 300);
    const float x = 2 * thing + 9 * draw(engine), y = std::fmod(thing * 71, 600.0f) + 9 * draw(engine);
    boxes.insert(boxes.end(), {x, y, x + 40, y + 60});
  }
  return [boxes, groups = std::vector<int64_t>(kCount), kept = std::make_unique<bool[]>(kCount)]() {
    nms(boxes.data(), 1, kCount, groups.data(), 0.45f, 300, kept.get());
  };
});
KERNEL_CALL_BENCHMARK(two_smallest, [] {
  return [x = kernel_benchmarks::random(2000 * 2000), out = std::vector<int64_t>(2 * 2000)]() mutable {
    two_smallest(x.data(), 1, 2000, 2000, false, out.data());
  };
});

TYPED_TEST(FeatureKernels, OrientationHistogramsMatchTheirDefinition) {
  using T = TypeParam;
  for (const auto& sizes : {std::array<int64_t, 3>{16, 4, 8}, {19, 1, 36}, {1, 1, 2}, {33, 3, 5}}) {
    constexpr int64_t count = 3;
    const int64_t size = sizes[0], places = sizes[1], bins = sizes[2];
    auto patches = this->random(count * size * size, 0, 1);
    std::fill_n(patches.begin(), size * size, T(0.5));  // a flat one
    const auto window = this->random(size * size, 0, 1);
    std::vector<T> space_weights(static_cast<size_t>(places * size));
    for (int64_t p = 0; p < places; ++p)
      for (int64_t i = 0; i < size; ++i)
        space_weights[size_t(p * size + i)] =
            std::max(T(0), 1 - std::abs((T(i) + T(0.5)) * T(places) / T(size) - T(p) - T(0.5)));
    std::vector<T> out(static_cast<size_t>(count * bins * places * places));
    orientation_histograms(patches.data(), count, size, window.data(), space_weights.data(), places, bins,
                           out.data());
    for (int64_t n = 0; n < count; ++n) {
      std::vector<double> expected(static_cast<size_t>(bins * places * places));
      const auto pixel = [&](int64_t y, int64_t x) {
        return double(patches[size_t((n * size + std::clamp<int64_t>(y, 0, size - 1)) * size +
                                     std::clamp<int64_t>(x, 0, size - 1))]);
      };
      for (int64_t y = 0; y < size; ++y)
        for (int64_t x = 0; x < size; ++x) {
          const double dx = (pixel(y, x + 1) - pixel(y, x - 1)) / 2,
                       dy = (pixel(y + 1, x) - pixel(y - 1, x)) / 2, length = std::hypot(dx, dy);
          const double place = std::atan2(dy, dx) / (2 * M_PI) * double(bins) + double(bins);
          for (int64_t k = 0; k < bins * places * places; ++k) {
            const double away = std::fmod(std::abs(place - double(k / (places * places))), double(bins)),
                         share = std::max(0.0, 1 - std::min(away, double(bins) - away));
            expected[size_t(k)] += length * double(window[size_t(y * size + x)]) * share *
                                   double(space_weights[size_t(k / places % places * size + y)]) *
                                   double(space_weights[size_t(k % places * size + x)]);
          }
        }
      for (size_t k = 0; k < expected.size(); ++k)
        ASSERT_NEAR(out[size_t(n) * expected.size() + k], expected[k], 2e-4) << size << ", entry " << k;
    }
  }
}

KERNEL_CALL_BENCHMARK(orientation_histograms, [] {
  return [x = kernel_benchmarks::random(500 * 41 * 41), window = kernel_benchmarks::random(41 * 41),
          weights = kernel_benchmarks::random(4 * 41), out = std::vector<float>(500 * 8 * 16)]() mutable {
    orientation_histograms(x.data(), 500, 41, window.data(), weights.data(), 4, 8, out.data());
  };
});

TYPED_TEST(FeatureKernels, ExtractPatchesReadsBilinearly) {
  using T = TypeParam;
  constexpr int64_t batch = 2, channels = 3, frames = 4, side = 18;
  const int64_t heights[] = {9, 20, 1, 7}, widths[] = {30, 11, 6, 1};  // four images in a row of pixels
  std::vector<int64_t> start, height, width;
  int64_t length = 0;
  for (int64_t k = 0; k < 4; ++k) {
    start.push_back(length);
    height.push_back(heights[k]);
    width.push_back(widths[k]);
    length += heights[k] * widths[k];
  }
  // the same for both samples
  for (auto* list : {&start, &height, &width}) list->insert(list->end(), list->begin(), list->begin() + 4);
  const auto pixels = this->random(batch * channels * length, 0, 1);
  auto matrices = this->random(batch * frames * 6, -12, 12);
  for (int k : {0, 1, 3, 4}) matrices[size_t(6 + k)] = 0;  // a point
  std::vector<T> out(static_cast<size_t>(batch * channels * frames * side * side));
  extract_patches(pixels.data(), batch, channels, length, start.data(), frames, height.data(), width.data(),
                  matrices.data(), side, out.data());
  for (int64_t i = 0; i < int64_t(out.size()); ++i) {
    const int64_t column = i % side, row = i / side % side, frame = i / (side * side) % frames,
                  plane = i / (side * side * frames), own = plane / channels * frames + frame;
    const double u = double(2 * column + 1) / side - 1, v = double(2 * row + 1) / side - 1;
    const T* const m = matrices.data() + 6 * own;
    const double x = std::clamp(m[0] * u + m[1] * v + m[2], 0.0, double(width[size_t(own)] - 1)),
                 y = std::clamp(m[3] * u + m[4] * v + m[5], 0.0, double(height[size_t(own)] - 1));
    const auto pixel = [&](double r, double c) {
      const int64_t yy = std::min(int64_t(r), height[size_t(own)] - 1),
                    xx = std::min(int64_t(c), width[size_t(own)] - 1);
      return double(pixels[size_t(plane * length + start[size_t(own)] + yy * width[size_t(own)] + xx)]);
    };
    const double r = std::floor(y), c = std::floor(x), fy = y - r, fx = x - c;
    const double expected = (pixel(r, c) * (1 - fx) + pixel(r, c + 1) * fx) * (1 - fy) +
                            (pixel(r + 1, c) * (1 - fx) + pixel(r + 1, c + 1) * fx) * fy;
    ASSERT_NEAR(out[size_t(i)], expected, 2e-5) << "frame " << frame << " at " << x << ", " << y;
  }
}

KERNEL_CALL_BENCHMARK(extract_patches, [] {
  return [x = kernel_benchmarks::random(480 * 640), start = std::vector<int64_t>(500),
          height = std::vector<int64_t>(500, 480), width = std::vector<int64_t>(500, 640),
          frames = kernel_benchmarks::random(500 * 6, 10, 200),
          out = std::vector<float>(500 * 32 * 32)]() mutable {
    extract_patches(x.data(), 1, 1, 480 * 640, start.data(), 500, height.data(), width.data(), frames.data(),
                    32, out.data());
  };
});

}  // namespace
