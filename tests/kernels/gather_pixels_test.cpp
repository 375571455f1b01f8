// Images of the pixels in some rows and columns, by the definition.
#include <numeric>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

template <class A>
class GatherPixels : public ::testing::Test {};
using Types = ::testing::Types<uint8_t, int16_t, uint16_t, float, double>;
TYPED_TEST_SUITE(GatherPixels, Types);

TYPED_TEST(GatherPixels, MatchesTheDefinition) {
  using A = TypeParam;
  constexpr int64_t kHeight = 5, kPixels = 37;
  const std::vector<int32_t> rows{-1, 4, 4, 0, 5, 2, 3};
  std::vector<int32_t> columns(kPixels);  // a run, mirrored at both ends, and what there is not
  std::iota(columns.begin(), columns.end(), 0);
  columns.insert(columns.begin(), {2, 1});
  columns.insert(columns.end(), {36, 35, 37, 38, -5, 7, -1});
  for (const int64_t step : {1, 2, 3, 4, 7}) {
    std::vector<A> x(static_cast<size_t>(2 * kHeight * kPixels * step));
    for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<A>(i % 251);
    const auto new_height = static_cast<int64_t>(rows.size()),
               new_width = static_cast<int64_t>(columns.size());
    std::vector<A> out(static_cast<size_t>(2 * new_height * new_width * step));
    gather_pixels(x.data(), 2, kHeight, kPixels * step, rows.data(), new_height, columns.data(), new_width,
                  step, 9.0, out.data());
    size_t at = 0;
    for (int64_t image = 0; image < 2; ++image)
      for (const int64_t row : rows)
        for (const int64_t column : columns)
          for (int64_t c = 0; c < step; ++c) {
            const bool there = row >= 0 && row < kHeight && column >= 0 && column < kPixels;
            const auto i = static_cast<size_t>(((image * kHeight + row) * kPixels + column) * step + c);
            ASSERT_EQ(out[at++], there ? x[i] : A(9)) << image << " " << row << " " << column << " " << c;
          }
  }
}

// A border of 16 pixels around a frame, mirrored.
KERNEL_CALL_BENCHMARK(gather_pixels, [] {
  const auto mirrored = [](int32_t size) {
    std::vector<int32_t> from;
    for (int32_t i = -16; i < size + 16; ++i) from.push_back(i < 0 ? -i : i < size ? i : 2 * size - 2 - i);
    return from;
  };
  return [x = std::vector<uint8_t>(1080 * 1920 * 3), out = std::vector<uint8_t>(1112 * 1952 * 3),
          rows = mirrored(1080), columns = mirrored(1920)]() mutable {
    gather_pixels(x.data(), 1, 1080, 1920 * 3, rows.data(), 1112, columns.data(), 1952, 3, 0.0, out.data());
  };
});

}  // namespace
