// The kernels' calls reject arguments that the loops do not support: with one sentence that names the
// argument, and without a result.
#include <gtest/gtest.h>

#include <functional>

#include "calls.h"
#include "fixture.h"

using namespace chiasm::artifact;
using kernel_calls::of;
using kernel_calls::Tensor;

namespace {

Tensor floats(const Dims& sizes) { return of<float>(sizes, {0.5f}); }
Tensor doubles(const Dims& sizes) { return of<double>(sizes, {0.5}); }
Tensor longs(const Dims& sizes, int64_t value) { return of<int64_t>(sizes, {value}); }
Tensor bytes(const Dims& sizes) { return of<uint8_t>(sizes, {7}); }

void expect_refused(const std::string& argument, const std::function<Call(Handle*)>& call) {
  Handle result = nullptr;
  kernel_calls::last_error.clear();
  ASSERT_NE(call(&result), 0) << argument;
  EXPECT_EQ(result, nullptr) << argument;
  EXPECT_EQ(kernel_calls::last_error.rfind(argument + ": expected ", 0), 0u) << kernel_calls::last_error;
}

// An image with more elements than its memory: the call must reject it by its sizes alone.
Tensor claimed(const Dims& sizes, int32_t dtype) {
  Tensor tensor = kernel_calls::make({1}, dtype);
  tensor->sizes = sizes;
  tensor->strides = dense_strides(sizes);
  return tensor;
}

#define REFUSES(argument, name, ...) \
  expect_refused(argument, [&](Handle* result) { return aoti_torch_cpu_##name(__VA_ARGS__, result); })

TEST(RefusedCalls, ShapesThatDoNotFit) {
  const Tensor x = floats({2, 3, 9, 11}), row = floats({1, 3}), none = floats({2, 3, 0, 11}),
               flat = floats({5}), other = doubles({1, 3});
  for (const Tensor* bad : {&none, &flat}) {
    REFUSES("separable: x", separable, bad->get(), row.get(), row.get(), 0, 1, 0);
    REFUSES("minmax_filter: x", minmax_filter, bad->get(), 1, 3, 3, 0, 0, 1);
    REFUSES("median_filter: x", median_filter, bad->get(), 1, 3, 0);
    REFUSES("integral: x", integral, bad->get());
    REFUSES("correlate2d: x", correlate2d, bad->get(), floats({1, 3, 3}).get(), 0);
    REFUSES("sobel: x", sobel, bad->get(), 1, 0);
    REFUSES("canny_nms: x", canny_nms, bad->get(), 0);
    REFUSES("canny_hysteresis: x", canny_hysteresis, bad->get(), 0, 1);
  }
  REFUSES("separable: taps_y", separable, x.get(), floats({3, 3}).get(), row.get(), 0, 1,
          0);  // neither 1 nor the batch
  REFUSES("separable: taps_x", separable, x.get(), row.get(), floats({1, 4}).get(), 0, 1, 0);
  REFUSES("separable: taps_x", separable, x.get(), row.get(), floats({1, 0}).get(), 0, 1, 0);
  REFUSES("separable: taps_y", separable, x.get(), flat.get(), row.get(), 0, 1, 0);
  REFUSES("separable: taps_y", separable, x.get(), other.get(), row.get(), 0, 1, 0);
  REFUSES("correlate2d: taps", correlate2d, x.get(), row.get(), 0);
  REFUSES("correlate2d: taps", correlate2d, x.get(), floats({1, 0, 3}).get(), 0);
  REFUSES("correlate2d: taps", correlate2d, x.get(), floats({3, 3, 3}).get(), 0);  // neither 1 nor the batch
  const Tensor near = floats({1, 3, 3}), fall = floats({1});
  REFUSES("bilateral: guide", bilateral, x.get(), floats({2, 3, 9, 10}).get(), near.get(), fall.get(), 0, 0);
  REFUSES("bilateral: guide", bilateral, x.get(), floats({3, 3, 9, 11}).get(), near.get(), fall.get(), 0, 0);
  REFUSES("bilateral: space_weights", bilateral, x.get(), x.get(), floats({1, 2, 3}).get(), fall.get(), 0, 0);
  REFUSES("bilateral: range_coefficient", bilateral, x.get(), x.get(), near.get(), floats({0}).get(), 0, 0);
  const Tensor rows = floats({2, 3, 12});
  REFUSES("morphology: heights", morphology, rows.get(), 1, floats({3, 3}).get(), 0, 0, 0, 0, 1e4, 1);
  REFUSES("morphology_gradient: erosion_heights", morphology_gradient, rows.get(), 1, doubles({3, 3}).get(),
          doubles({3, 4}).get(), 0, 0, 0, 0, 0, 1e4);
  REFUSES("median_filter: x", median_filter, x.get(), 1, 3, 0);
  REFUSES("rank_of_bytes: x", rank_of_bytes, rows.get(), 1, 3, 3, 4, 0);
  REFUSES("remap: x", remap, x.get(), floats({1, 4, 4}).get(), floats({2, 4, 4}).get(), 0, 0, 0);
  REFUSES("remap: y", remap, x.get(), floats({2, 4, 4}).get(), floats({2, 4, 3}).get(), 0, 0, 0);
  REFUSES("remap: image", remap, none.get(), floats({2, 4, 4}).get(), floats({2, 4, 4}).get(), 0, 0, 0);
  REFUSES("warp_perspective: matrix", warp_perspective, x.get(), floats({2, 2, 3}).get(), 4, 4, 0, 0, 0);
  REFUSES("resize: x", resize, none.get(), 4, 4, 0, 0, 0);
  const Tensor taps = of<int32_t>({4, 2}, {7});
  REFUSES("resample_bytes: down", resample_bytes, bytes({2, 5, 6}).get(), longs({4, 3}, 0).get(), taps.get(),
          longs({4, 2}, 0).get(), taps.get(), 3);
  REFUSES("resample_bytes: across", resample_bytes, bytes({2, 5, 6}).get(), longs({4, 2}, 0).get(),
          taps.get(), longs({5, 2}, 0).get(), taps.get(), 3);
  REFUSES("resample_bytes: x", resample_bytes, bytes({2, 0, 6}).get(), longs({4, 2}, 0).get(), taps.get(),
          longs({4, 2}, 0).get(), taps.get(), 3);
  const Tensor four = longs({7, 4}, 0);
  REFUSES("resize_cubic_bytes: down", resize_cubic_bytes, bytes({2, 5, 6}).get(), four.get(),
          longs({6, 4}, 0).get(), four.get(), four.get(), 3);
  REFUSES("resize_cubic_bytes: columns", resize_cubic_bytes, bytes({2, 5, 6}).get(), four.get(), four.get(),
          longs({7, 5}, 0).get(), four.get(), 3);
  REFUSES("demosaiced: x", demosaiced, bytes({2, 1, 6}).get(), 0, 0, 1);
  REFUSES("demosaiced: x", demosaiced, floats({2, 4, 6}).get(), 0, 0, 1);
  REFUSES("luv_pixels: light", luv_pixels, bytes({2, 9}).get(), doubles({255}).get(), doubles({3, 3}).get(),
          doubles({9}).get(), 1);
  REFUSES("resize_blurred: taps", resize_blurred, x.get(), floats({4}).get(), 4, 4, 0, 0, 1);
  REFUSES("aminmax: x", aminmax, floats({2, 0}).get());
  REFUSES("row_histograms: low", row_histograms, floats({2, 9}).get(), floats({1, 1}).get(),
          floats({2, 1}).get(), 8);
  REFUSES("lut: table", lut, floats({2, 255}).get(), bytes({2, 9}).get());
  REFUSES("lut: index", lut, floats({1, 256}).get(), bytes({2, 9}).get());
  REFUSES("score_models: points", score_models, floats({2, 5, 3, 3}).get(), floats({2, 6, 9}).get(), 0, 1);
  REFUSES("batched_inverse: m", batched_inverse, doubles({17, 17}).get());
  REFUSES("spd_inverse: m", spd_inverse, doubles({3, 4}).get());
  REFUSES("normalized_power: m", normalized_power, floats({3, 3}).get(), 5);
  REFUSES("weighted_grams: x", weighted_grams, doubles({2, 5, 17}).get(), doubles({2, 5, 1}).get());
  REFUSES("weighted_grams: weights", weighted_grams, doubles({2, 5, 9}).get(), doubles({2, 4, 1}).get());
  REFUSES("cdist_squared: x2", cdist_squared, floats({1, 4, 5}).get(), floats({1, 4, 6}).get());
  REFUSES("two_smallest: x", two_smallest, floats({4, 5}).get(), 1);
  REFUSES("scale_space_nms: margins", scale_space_nms, x.get(), longs({2}, 1).get(), 0, 4);
  REFUSES("orientation_histograms: patches", orientation_histograms, floats({2, 5, 6}).get(),
          floats({5, 5}).get(), floats({4, 5}).get(), 8);
  REFUSES("orientation_histograms: patches", orientation_histograms, floats({2, 1, 5, 5}).get(),
          floats({5, 5}).get(), floats({4, 5}).get(), 8);
  REFUSES("orientation_histograms: window", orientation_histograms, floats({2, 5, 5}).get(),
          floats({4, 5}).get(), floats({4, 5}).get(), 8);
  REFUSES("frame_to_grey: frame", frame_to_grey, bytes({4, 4, 4}).get());
  REFUSES("resize_frame: frame", resize_frame, bytes({4, 1, 3}).get(), 2, 2);
}

TEST(RefusedCalls, NumbersOutOfTheirRange) {
  const Tensor x = floats({2, 3, 9, 11}), window = doubles({3, 3}), positions = floats({2, 4, 4});
  const Tensor rows = floats({2, 9, 12}), levels = bytes({2, 9, 12});
  for (const int64_t border : {int64_t{-1}, int64_t{4}, INT64_MAX}) {
    REFUSES("median_filter: border", median_filter, rows.get(), 1, 3, border);
    REFUSES("minmax_filter: border", minmax_filter, rows.get(), 1, 3, 3, border, 0, 1);
  }
  for (const int64_t step : {0, 13}) REFUSES("median_filter: step", median_filter, rows.get(), step, 3, 0);
  REFUSES("median_filter: x", median_filter, rows.get(), 5, 3, 0);  // 12 values cannot be pixels of 5
  for (const int64_t size : {1, 4, 9}) REFUSES("median_filter: size", median_filter, rows.get(), 1, size, 0);
  for (const int64_t rank : {-1, 15})
    REFUSES("rank_of_bytes: rank", rank_of_bytes, levels.get(), 1, 3, 5, rank, 0);
  REFUSES("rank_of_bytes: ky", rank_of_bytes, levels.get(), 1, 257, 257, 0, 0);
  REFUSES("minmax_filter: ky", minmax_filter, rows.get(), 1, 0, 3, 0, 0, 1);
  REFUSES("morphology: row", morphology, rows.get(), 1, window.get(), 3, 0, 0, 0, 1e4, 1);
  REFUSES("morphology: column", morphology, rows.get(), 1, window.get(), 0, -1, 0, 0, 1e4, 1);
  REFUSES("remap: mode", remap, x.get(), positions.get(), positions.get(), 3, 0, 0);
  REFUSES("remap: padding", remap, x.get(), positions.get(), positions.get(), 0, 3, 0);
  REFUSES("warp_perspective: height", warp_perspective, x.get(), floats({2, 3, 3}).get(), -1, 4, 0, 0, 0);
  REFUSES("resize: mode", resize, x.get(), 4, 4, 3, 0, 0);
  REFUSES("resize: width", resize, x.get(), 4, 0, 0, 0, 0);
  const Tensor four = longs({7, 4}, 0);
  for (const int64_t weight : {int64_t{-4097}, INT64_MAX}) {
    const Tensor heavy = longs({7, 4}, weight);
    REFUSES("resize_cubic_bytes: down", resize_cubic_bytes, levels.get(), four.get(), heavy.get(), four.get(),
            four.get(), 3);
    REFUSES("resize_cubic_bytes: across", resize_cubic_bytes, levels.get(), four.get(), four.get(),
            four.get(), heavy.get(), 3);
  }
  REFUSES("integral_bytes: step", integral_bytes, levels.get(), 0);
  REFUSES("demosaiced: red_row", demosaiced, levels.get(), 2, 0, 1);
  REFUSES("resize_frame: height", resize_frame, bytes({4, 4, 3}).get(), 0, 2);
  for (const int64_t bins : {0, (1 << 24) + 1})
    REFUSES("row_histograms: bins", row_histograms, floats({2, 9}).get(), floats({2, 1}).get(),
            floats({2, 1}).get(), bins);
  REFUSES("bincount: bins", bincount, bytes({2, 9}).get(), -5);
  REFUSES("bincount: x", bincount, longs({2, 9}, 1).get(), 8);
  REFUSES("clahe_histograms: tile_height", clahe_histograms, bytes({2, 9, 9}).get(), 1 << 20, 1 << 20, 2, 2);
  REFUSES("score_models: count", score_models, floats({2, 5, 3, 3}).get(), floats({2, 7, 9}).get(), 0, 0);
  REFUSES("real_roots: coefficients", real_roots, doubles({18, 3}).get());
  REFUSES("real_roots: coefficients", real_roots, doubles({0, 3}).get());
  REFUSES("scale_space_nms: count", scale_space_nms, x.get(), longs({3}, 1).get(), 0, -1);
  REFUSES("scale_space_nms: margins", scale_space_nms, x.get(), longs({3}, INT64_MIN).get(), 0, 1);
  REFUSES("orientation_histograms: bins", orientation_histograms, floats({2, 5, 5}).get(),
          floats({5, 5}).get(), floats({4, 5}).get(), 0);
}

TEST(RefusedCalls, IndicesBeyondTheirTables) {
  const Tensor pixels = floats({1, 2, 20}), frames = floats({1, 3, 2, 3});
  const auto patches = [&](int64_t start, int64_t height, int64_t width, const char* argument) {
    REFUSES(argument, extract_patches, pixels.get(), longs({1, 3}, start).get(), longs({1, 3}, height).get(),
            longs({1, 3}, width).get(), frames.get(), 4);
  };
  patches(-1, 4, 5, "extract_patches: start");
  patches(21, 1, 1, "extract_patches: start");
  patches(0, 0, 5, "extract_patches: height");
  patches(0, 4, -5, "extract_patches: width");
  patches(1, 4, 5, "extract_patches: height");
  patches(20, 1, 1, "extract_patches: height");
  patches(0, INT64_MAX, 2, "extract_patches: height");
  const Tensor levels = bytes({2, 4, 5}), table = floats({2, 6, 256}), wy = floats({4}), wx = floats({5});
  const auto blend = [&](int64_t y, int64_t x, const char* argument) {
    REFUSES(argument, clahe_interpolate, table.get(), 3, levels.get(), longs({4}, 0).get(),
            longs({4}, y).get(), wy.get(), longs({5}, x).get(), longs({5}, 2).get(), wx.get());
  };
  blend(2, 0, "clahe_interpolate: second_y");
  blend(-1, 0, "clahe_interpolate: second_y");
  blend(1, 3, "clahe_interpolate: first_x");
  REFUSES("clahe_interpolate: tiles_x", clahe_interpolate, table.get(), 7, levels.get(), longs({4}, 0).get(),
          longs({4}, 0).get(), wy.get(), longs({5}, 0).get(), longs({5}, 0).get(), wx.get());
}

TEST(RefusedCalls, ShapesThatDoNotFitTheirWindows) {
  const Tensor x = floats({2, 9, 11}), other = floats({2, 9, 10}), none = floats({2, 0, 11}),
               element = kernel_calls::make({3, 3}, kBool), empty = kernel_calls::make({3, 0}, kBool);
  REFUSES("euclidean_distances: x", euclidean_distances, none.get());
  REFUSES("connected_components: x", connected_components, none.get());
  const Tensor mask = kernel_calls::make({2, 9, 11}, kUint8);
  REFUSES("outlines: polygons", outlines, mask.get(), 0, 9);
  REFUSES("outlines: numbers", outlines, mask.get(), 1, 2);
  REFUSES("thinned: x", thinned, none.get(), 9, 1);
  REFUSES("thinned: limit", thinned, x.get(), -1, 1);
  REFUSES("grown_distances: taps", grown_distances, x.get(), floats({3, 5}).get(), 0.35, 9);
  REFUSES("grown_distances: taps", grown_distances, x.get(), floats({4, 4}).get(), 0.35, 9);
  REFUSES("grown_distances: limit", grown_distances, x.get(), floats({3, 3}).get(), 0.35, -1);
  REFUSES("reconstructed: mask", reconstructed, x.get(), other.get(), element.get(), 0, 1);
  REFUSES("reconstructed: element", reconstructed, x.get(), x.get(), empty.get(), 0, 1);
}

TEST(RefusedCalls, PaintThatDoesNotFitTheImage) {
  const Tensor x = floats({2, 3, 9, 11}), corners = longs({2, 5, 4}, 1), colors = floats({2, 3, 5}),
               rows = longs({2, 2, 9}, 1), other = longs({2, 2, 8}, 1);
  REFUSES("draw_rectangles: corners", draw_rectangles, x.get(), longs({2, 5, 3}, 1).get(), colors.get(), 0, 0,
          1);
  REFUSES("draw_rectangles: colors", draw_rectangles, x.get(), corners.get(), floats({2, 3, 4}).get(), 0, 0,
          1);
  REFUSES("draw_rectangles: before", draw_rectangles, x.get(), corners.get(), colors.get(), -1, 0, 1);
  REFUSES("draw_rectangles: after", draw_rectangles, x.get(), corners.get(), colors.get(), 0, INT64_MAX, 1);
  REFUSES("fill_spans: end", fill_spans, x.get(), rows.get(), other.get(), floats({2, 3}).get());
  REFUSES("fill_spans: colors", fill_spans, x.get(), rows.get(), rows.get(), floats({1, 3}).get());
}

// More pixels than 32 bits can index: the kernels' offsets would wrap around.
TEST(RefusedCalls, ImagesTooLargeForTheirNumbers) {
  const Tensor image = claimed({1, 1, 1 << 16, 1 << 15}, kFloat),
               line = claimed({1, 1, 1, (1 << 24) + 1}, kFloat);
  REFUSES("connected_components: x", connected_components, image.get());
  REFUSES("thinned: x", thinned, image.get(), 9, 1);
  REFUSES("euclidean_distances: x", euclidean_distances, line.get());
  REFUSES("canny_hysteresis: x", canny_hysteresis, image.get(), 0, 1);
  const Tensor positions = floats({1, 4, 4});
  REFUSES("remap: image", remap, image.get(), positions.get(), positions.get(), 0, 0, 0);
  REFUSES("remap: image", remap, line.get(), positions.get(), positions.get(), 0, 0,
          0);  // float32 cannot represent the positions of its last pixels
  const Tensor row = claimed({1, int64_t{1} << 31}, kFloat), one = floats({1, 1});
  REFUSES("row_histograms: x", row_histograms, row.get(), one.get(), one.get(), 8);
}

TEST(RefusedCalls, TopkOfMoreThanThereIs) {
  const Tensor x = floats({2, 5});
  for (const int64_t k : {int64_t{-1}, int64_t{6}, INT64_MIN}) {
    Handle values = nullptr, indices = nullptr;
    EXPECT_NE(aoti_torch_cpu_topk(x.get(), k, -1, 1, 1, &values, &indices), 0);
    EXPECT_EQ(kernel_calls::last_error,
              "topk: " + std::to_string(k) + " values asked for, the dimension has 5");
  }
}

// A guide with the same address as the image that is not the whole image: its first planes, or its first
// sample.
class KernelCalls : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }
};

TEST_F(KernelCalls, AGuideThatIsAPartOfTheImage) {
  std::vector<float> values(size_t(2 * 3 * 9 * 11));
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i * 7919 % 101) / 100;
  const Tensor near = floats({1, 3, 3}), fall = of<float>({1}, {-3.0f});
  const auto filtered = [&](const Tensor& x, const Tensor& guide) {
    Handle result = nullptr;
    EXPECT_EQ(aoti_torch_cpu_bilateral(x.get(), guide.get(), near.get(), fall.get(), 0, 0, &result), 0)
        << kernel_calls::last_error;
    const Tensor tensor(result);
    const auto* const data = reinterpret_cast<const float*>(tensor->data());
    return std::vector<float>(data, data + tensor->numel());
  };
  const auto part = [](const Tensor& whole, const Dims& sizes) {
    Tensor view = std::make_unique<AtenTensorOpaque>(*whole);
    view->sizes = sizes;
    view->strides = dense_strides(sizes);
    return view;
  };
  const Tensor image = of({1, 3, 9, 11}, values), batch = of({2, 3, 9, 11}, values);
  const Tensor plane = part(image, {1, 1, 9, 11}), first = part(batch, {1, 3, 9, 11});
  EXPECT_EQ(filtered(plane, image), filtered(of({1, 1, 9, 11}, values), of({1, 3, 9, 11}, values)));
  EXPECT_EQ(filtered(image, plane), filtered(of({1, 3, 9, 11}, values), of({1, 1, 9, 11}, values)));
  EXPECT_EQ(filtered(batch, first), filtered(of({2, 3, 9, 11}, values), of({1, 3, 9, 11}, values)));
}

TEST(RefusedCalls, WindowsOfNetworks) {
  const auto packed = [](const char* argument, const Tensor& x, const Tensor& weight, const Tensor& bias,
                         int64_t stride = 1, int64_t top = 0, int64_t height = 4) {
    REFUSES(argument, packed_convolution, x.get(), weight.get(), bias.get(), stride, 1, top, 0, 1, 1, height,
            4, 0, 6);
  };
  const Tensor x = floats({1, 4, 4, 6}), weight = floats({2, 1, 1, 3, 16}), bias = floats({34});
  packed("packed_convolution: weight", x, floats({2, 1, 1, 6, 8}), bias);
  packed("packed_convolution: weight", x, doubles({2, 1, 1, 3, 16}), bias);
  packed("packed_convolution: bias", x, weight, doubles({34}));
  packed("packed_convolution: x", x, floats({2, 1, 1, 4, 16}), bias);  // 6 channels cannot form groups of 4
  packed("packed_convolution: bias", x, weight, floats({33}));         // 33 outputs of two groups
  packed("packed_convolution: weight", x, weight, bias);               // 17 outputs have two panels
  packed("packed_convolution: stride_y", x, weight, floats({32}), 0);
  packed("packed_convolution: top", x, weight, floats({32}), 1, -1);
  packed("packed_convolution: height", x, weight, floats({32}), 1, 0, -1);
  REFUSES("depthwise_convolution: bias", depthwise_convolution, x.get(), floats({3, 3, 6}).get(),
          floats({5}).get(), 1, 1, 1, 1, 1, 1, 4, 4, 0, 6);
}

}  // namespace
