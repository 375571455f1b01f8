// How AOTInductor's code calls the kernels: as the operators chiasm::... of python/chiasm/primitives/kernels.py, which has these
// declarations too. Everything that the loops assume is checked here: they check nothing.
#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include "arguments.h"

using namespace chiasm::artifact;
using namespace chiasm::kernels;

namespace {

using Result = std::unique_ptr<AtenTensorOpaque>;

Result make(const Dims& sizes, int32_t dtype) { return Result(allocate(sizes, dense_strides(sizes), dtype)); }

template <class T>
T* data(Result& tensor) { return reinterpret_cast<T*>(tensor->data()); }

// Calls body(T{}) with the floating-point type, which arguments that are kFloating have.
template <class Body>
void for_type(int32_t dtype, const Body& body) {
  if (dtype == kFloat) body(float{});
  else body(double{});
}

// Has body(image, planes, its data, the result's data) make a tensor of x's sizes and type.
template <class Body>
AOTITorchError like_image(const char* name, AtenTensorHandle x, AtenTensorHandle* result, const Body& body) {
  return guarded([&] {
    const Argument image(name, x, kFloating);
    const Planes planes = image.planes();
    Result out = make(image.sizes(), image.dtype());
    for_type(image.dtype(), [&](auto zero) {
      using T = decltype(zero);
      body(image, planes, image.data<T>(), data<T>(out));
    });
    *result = out.release();
  });
}

// Has body(matrices, planes, the result's data) make matrices like m.
template <class Body>
AOTITorchError like_matrices(const char* name, AtenTensorHandle m, AtenTensorHandle* result, const Body& body) {
  return guarded([&] {
    const Argument matrices(name, m, kDouble);
    const Planes planes = matrices.planes();
    if (planes.height != planes.width || planes.height > kMostRows) refuse(name, "square matrices of at most 16 rows", to_text(matrices.sizes().data(), matrices.sizes().size()));
    Result out = make(matrices.sizes(), kDouble);
    body(matrices.data<double>(), planes, data<double>(out));
    *result = out.release();
  });
}

// Has taps(T{}, size, new size) say how each axis of an image (B, C, H, W) is resampled.
template <class MakeTaps>
AOTITorchError resampled(AtenTensorHandle x, int64_t height, int64_t width, AtenTensorHandle* result, const MakeTaps& taps) {
  return guarded([&] {
    const Argument image("resize: x", x, kFloating, {kAny, kAny, kAny, kAny});
    const Planes planes = image.planes();
    within("resize: height", height, 1, kMostIndex);
    within("resize: width", width, 1, kMostIndex);
    Result out = make({image.size(0), image.size(1), height, width}, image.dtype());
    for_type(image.dtype(), [&](auto zero) {
      using T = decltype(zero);
      resample(image.data<T>(), planes, taps(zero, planes.height, height), taps(zero, planes.width, width), data<T>(out));
    });
    *result = out.release();
  });
}

// A frame (H, W, 3) of bytes, two pixels wide or more.
Argument frame_argument(const char* name, AtenTensorHandle frame) {
  Argument image(name, frame, kUint8, {kAny, kAny, 3});
  within(name, image.size(0), 1, kMostIndex);
  within(name, image.size(1), 2, kMostIndex);
  return image;
}

// What `sample` reads, (B, C, H, W): small enough for the numbers of its pixels, and for its sides as numbers of its type.
Images images_of(const Argument& source) {
  const Images images{source.size(0), source.size(1), source.size(2), source.size(3)};
  const int64_t longest = source.dtype() == kFloat ? int64_t{1} << 24 : kMostIndex - 1;
  within(source.name(), images.height, 1, longest);
  within(source.name(), images.width, 1, longest);
  within(source.name(), (images.height + 1) * (images.width + 1), 1, kMostIndex);  // with the row and column that an image of one pixel is widened by
  return images;
}

Interpolation interpolation_of(int64_t mode) { return choice<Interpolation>("sample: mode", mode, 2); }
Padding padding_of(int64_t padding) { return choice<Padding>("sample: padding", padding, 3); }

}  // namespace

extern "C" {

AOTITorchError aoti_torch_cpu_frame_to_grey(AtenTensorHandle frame, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image = frame_argument("frame_to_grey: frame", frame);
    Result out = make({1, 1, image.size(0), image.size(1)}, kFloat);
    frame_to_grey(image.data<uint8_t>(), image.size(0) * image.size(1), data<float>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_resize_frame(AtenTensorHandle frame, int64_t height, int64_t width, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image = frame_argument("resize_frame: frame", frame);
    within("resize_frame: height", height, 1, kMostIndex);
    within("resize_frame: width", width, 1, kMostIndex);
    Result out = make({1, 3, height, width}, kFloat);
    resize_frame(image.data<uint8_t>(), image.size(0), image.size(1), height, width, data<float>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_separable(AtenTensorHandle x, AtenTensorHandle kernel_y, AtenTensorHandle kernel_x, int64_t border, double scale, double centre,
                                        AtenTensorHandle* result) {
  return like_image("separable: x", x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    const Argument column("separable: kernel_y", kernel_y, image.dtype(), {kAny, kAny}), row("separable: kernel_x", kernel_x, image.dtype(), {kAny, kAny});
    const int64_t batch = image.sizes().size() > 2 ? image.size(0) : 1, channels = batch ? planes.count / batch : 0;
    separable(in, planes, column.data<T>(), odd_size(column, 1), is_shared(column, batch) ? 0 : channels, row.data<T>(), odd_size(row, 1),
              is_shared(row, batch) ? 0 : channels, border_of(border), static_cast<T>(scale), static_cast<T>(centre), out);
  });
}

AOTITorchError aoti_torch_cpu_correlate2d(AtenTensorHandle x, AtenTensorHandle kernel, int64_t border, AtenTensorHandle* result) {
  return like_image("correlate2d: x", x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    const Argument taps("correlate2d: kernel", kernel, image.dtype(), {kAny, kAny, kAny});
    within("correlate2d: kernel", taps.size(1) * taps.size(2), 1, kMostIndex);
    const int64_t batch = image.sizes().size() > 2 ? image.size(0) : 1, channels = batch ? planes.count / batch : 0;
    correlate2d(in, planes, taps.data<T>(), taps.size(1), taps.size(2), is_shared(taps, batch) ? 0 : channels, border_of(border), out);
  });
}

AOTITorchError aoti_torch_cpu_bilateral(AtenTensorHandle x, AtenTensorHandle guide, AtenTensorHandle nearness, AtenTensorHandle falloff, int64_t border,
                                        int32_t squares, AtenTensorHandle* result) {
  return like_image("bilateral: x", x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    if (image.sizes().size() != 4) refuse(image.name(), "four dimensions", std::to_string(image.sizes().size()));
    const Argument guidance("bilateral: guide", guide, image.dtype(), {kAny, kAny, planes.height, planes.width});
    const Argument near("bilateral: nearness", nearness, image.dtype(), {kAny, kAny, kAny}), fall("bilateral: falloff", falloff, image.dtype(), {kAny});
    const int64_t batch = image.size(0);
    bilateral(in, image.size(1), guidance.data<T>(), guidance.size(1), is_shared(guidance, batch), {batch, planes.height, planes.width}, near.data<T>(),
              is_shared(near, batch), odd_size(near, 1), odd_size(near, 2), fall.data<T>(), is_shared(fall, batch), border_of(border), squares != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_rectangle_extreme(AtenTensorHandle x, int64_t rows, int64_t columns, int64_t border, double value, int32_t largest,
                                                AtenTensorHandle* result) {
  return like_image("rectangle_extreme: x", x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) {
    within("rectangle_extreme: rows", rows, 1, kMostIndex);
    within("rectangle_extreme: columns", columns, 1, kMostIndex);
    rectangle_extreme(in, planes, rows, columns, border_of(border), static_cast<T>(value), largest != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_structured_extreme(AtenTensorHandle x, AtenTensorHandle heights, int64_t row, int64_t column, int64_t border, double value,
                                                 double absent, int32_t largest, AtenTensorHandle* result) {
  return like_image("structured_extreme: x", x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    const Argument window("structured_extreme: heights", heights, image.dtype(), {kAny, kAny});
    within("structured_extreme: row", row, 0, window.size(0) - 1);
    within("structured_extreme: column", column, 0, window.size(1) - 1);
    structured_extreme(in, planes, window.data<T>(), window.size(0), window.size(1), row, column, border_of(border), static_cast<T>(value),
                       static_cast<T>(absent), largest != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_structured_range(AtenTensorHandle x, AtenTensorHandle high_window, AtenTensorHandle low_window, int64_t row, int64_t column,
                                               int64_t border, double high_value, double low_value, double absent, AtenTensorHandle* result) {
  return like_image("structured_range: x", x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    const Argument high("structured_range: high_window", high_window, image.dtype(), {kAny, kAny});
    const Argument low("structured_range: low_window", low_window, image.dtype(), {high.size(0), high.size(1)});
    within("structured_range: row", row, 0, high.size(0) - 1);
    within("structured_range: column", column, 0, high.size(1) - 1);
    structured_range(in, planes, high.data<T>(), low.data<T>(), high.size(0), high.size(1), row, column, border_of(border), static_cast<T>(high_value),
                     static_cast<T>(low_value), static_cast<T>(absent), out);
  });
}

AOTITorchError aoti_torch_cpu_median3x3(AtenTensorHandle x, int64_t border, AtenTensorHandle* result) {
  return like_image("median3x3: x", x, result,
                    [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { median3x3(in, planes, border_of(border), out); });
}

AOTITorchError aoti_torch_cpu_integral(AtenTensorHandle x, AtenTensorHandle* result) {
  return like_image("integral: x", x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { integral(in, planes, out); });
}

AOTITorchError aoti_torch_cpu_sample(AtenTensorHandle src, AtenTensorHandle x, AtenTensorHandle y, int64_t mode, int64_t padding, int32_t corners,
                                     AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source("sample: src", src, kFloating, {kAny, kAny, kAny, kAny});
    const Images images = images_of(source);
    const Argument column("sample: x", x, source.dtype(), {images.count, kAny, kAny}), row("sample: y", y, source.dtype(), {images.count, column.size(1), column.size(2)});
    Result out = make({images.count, images.channels, column.size(1), column.size(2)}, source.dtype());
    for_type(source.dtype(), [&](auto zero) {
      using T = decltype(zero);
      sample(source.data<T>(), images, column.data<T>(), row.data<T>(), column.size(1), column.size(2), interpolation_of(mode), padding_of(padding),
             corners != 0, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_sample_projective(AtenTensorHandle src, AtenTensorHandle matrix, int64_t height, int64_t width, int64_t mode, int64_t padding,
                                                int32_t corners, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source("sample_projective: src", src, kFloating, {kAny, kAny, kAny, kAny});
    const Images images = images_of(source);
    const Argument matrices("sample_projective: matrix", matrix, source.dtype(), {images.count, 3, 3});
    within("sample_projective: height", height, 0, kMostIndex);
    within("sample_projective: width", width, 0, kMostIndex);
    Result out = make({images.count, images.channels, height, width}, source.dtype());
    for_type(source.dtype(), [&](auto zero) {
      using T = decltype(zero);
      sample_projective(source.data<T>(), images, matrices.data<T>(), height, width, interpolation_of(mode), padding_of(padding), corners != 0, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_resize(AtenTensorHandle x, int64_t height, int64_t width, int64_t filter, int32_t corners, int32_t antialias,
                                     AtenTensorHandle* result) {
  return resampled(x, height, width, result, [&]<class T>(T, int64_t in, int64_t out) {
    return resize_taps<T>(in, out, choice<Filter>("resize: filter", filter, 3), corners != 0, antialias != 0);
  });
}

AOTITorchError aoti_torch_cpu_resize_blurred(AtenTensorHandle x, AtenTensorHandle kernel, int64_t height, int64_t width, int32_t corners, int64_t border,
                                             int32_t before, AtenTensorHandle* result) {
  return resampled(x, height, width, result, [&]<class T>(T, int64_t in, int64_t out) {
    const Argument given("resize_blurred: kernel", kernel, x->dtype, {kAny});
    const std::vector<T> weights(given.data<T>(), given.data<T>() + odd_size(given, 0));
    const Taps<T> taps = resize_taps<T>(in, out, Filter::kBilinear, corners != 0, false);
    return before ? blurred_before(taps, weights, border_of(border), in) : blurred_after(taps, weights, border_of(border));
  });
}

AOTITorchError aoti_torch_cpu_sobel(AtenTensorHandle x, double scale, double eps, AtenTensorHandle* result) {
  return like_image("sobel: x", x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) {
    sobel(in, planes, static_cast<T>(scale), static_cast<T>(eps), out);
  });
}

AOTITorchError aoti_torch_cpu_ridges(AtenTensorHandle x, double eps, AtenTensorHandle* result) {
  return like_image("ridges: x", x, result,
                    [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { ridges(in, planes, static_cast<T>(eps), out); });
}

AOTITorchError aoti_torch_cpu_extents(AtenTensorHandle x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values("extents: x", x, kFloating, {kAny, kAny});
    within("extents: x", values.size(1), 1, std::numeric_limits<int64_t>::max());
    Result out = make({2, values.size(0), 1}, values.dtype());
    for_type(values.dtype(), [&](auto zero) {
      using T = decltype(zero);
      extents(values.data<T>(), values.size(0), values.size(1), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_to_levels(AtenTensorHandle x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values("to_levels: x", x, kFloating);
    Result levels = make(values.sizes(), kUint8);
    for_type(values.dtype(), [&](auto zero) {
      using T = decltype(zero);
      to_levels(values.data<T>(), values.numel(), data<uint8_t>(levels));
    });
    *result = levels.release();
  });
}

AOTITorchError aoti_torch_cpu_bin_counts(AtenTensorHandle x, AtenTensorHandle low, AtenTensorHandle span, int64_t bins, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values("bin_counts: x", x, kFloating, {kAny, kAny});
    const int64_t rows = values.size(0), n = within("bin_counts: x", values.size(1), 0, kMostIndex);
    const Argument least("bin_counts: low", low, values.dtype(), {rows, 1}), width("bin_counts: span", span, values.dtype(), {rows, 1});
    within("bin_counts: bins", bins, 1, int64_t{1} << 24);  // whose numbers float32 has
    Result counts = make({rows, bins}, kInt32);
    for_type(values.dtype(), [&](auto zero) {
      using T = decltype(zero);
      bin_counts(values.data<T>(), least.data<T>(), width.data<T>(), rows, n, bins, data<int32_t>(counts));
    });
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_count_each(AtenTensorHandle index, int64_t bins, AtenTensorHandle* result) {
  return guarded([&] {
    const bool bytes = index->dtype == kUint8;
    const Argument numbers("count_each: index", index, bytes ? kUint8 : kInt32, {kAny, kAny});
    const int64_t rows = numbers.size(0), n = within("count_each: index", numbers.size(1), 0, kMostIndex);
    within("count_each: bins", bins, 1, kMostIndex);
    Result counts = make({rows, bins}, kInt32);
    if (bytes) count_each(numbers.data<uint8_t>(), rows, n, bins, data<int32_t>(counts));
    else count_each(numbers.data<int32_t>(), rows, n, bins, data<int32_t>(counts));
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_look_up(AtenTensorHandle table, AtenTensorHandle index, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument entries("look_up: table", table, kFloating, {kAny, 256}), levels("look_up: index", index, kUint8, {entries.size(0), kAny});
    Result out = make(levels.sizes(), entries.dtype());
    for_type(entries.dtype(), [&](auto zero) {
      using T = decltype(zero);
      look_up(entries.data<T>(), levels.data<uint8_t>(), levels.size(0), levels.size(1), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_tile_counts(AtenTensorHandle levels, int64_t tile_y, int64_t tile_x, int64_t tiles_y, int64_t tiles_x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image("tile_counts: levels", levels, kUint8, {kAny, kAny, kAny});
    const Planes planes = image.planes();
    within("tile_counts: tile_y", tile_y, 1, kMostIndex);
    within("tile_counts: tile_x", tile_x, 1, kMostIndex / tile_y);  // a tile's pixels are counted by 32 bits
    within("tile_counts: tiles_y", tiles_y, 1, kMostIndex);
    within("tile_counts: tiles_x", tiles_x, 1, kMostIndex);
    Result counts = make({image.size(0), tiles_y * tiles_x, 256}, kInt32);
    tile_counts(image.data<uint8_t>(), planes, tile_y, tile_x, tiles_y, tiles_x, data<int32_t>(counts));
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_blend_curves(AtenTensorHandle table, int64_t tiles_x, AtenTensorHandle levels, AtenTensorHandle first_y, AtenTensorHandle second_y,
                                           AtenTensorHandle weight_y, AtenTensorHandle first_x, AtenTensorHandle second_x, AtenTensorHandle weight_x,
                                           AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image("blend_curves: levels", levels, kUint8, {kAny, kAny, kAny});
    const Planes planes = image.planes();
    const Argument curves("blend_curves: table", table, kFloat, {planes.count, kAny});
    const int64_t tiles = curves.size(1) / 256;
    within("blend_curves: tiles_x", tiles_x, 1, tiles);
    const Argument y0("blend_curves: first_y", first_y, kInt64, {planes.height}), y1("blend_curves: second_y", second_y, kInt64, {planes.height});
    const Argument x0("blend_curves: first_x", first_x, kInt64, {planes.width}), x1("blend_curves: second_x", second_x, kInt64, {planes.width});
    const Argument wy("blend_curves: weight_y", weight_y, kFloat, {planes.height}), wx("blend_curves: weight_x", weight_x, kFloat, {planes.width});
    const int64_t last_y = tiles / tiles_x - 1, last_x = tiles_x - 1;
    Result out = make(image.sizes(), kUint8);
    blend_curves(curves.data<float>(), tiles, tiles_x, image.data<uint8_t>(), planes, indices(y0, 0, last_y), indices(y1, 0, last_y), wy.data<float>(),
                 indices(x0, 0, last_x), indices(x1, 0, last_x), wx.data<float>(), data<uint8_t>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_component_roots(AtenTensorHandle mask, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument set("component_roots: mask", mask, kBool, {kAny, kAny, kAny});
    const Planes planes = set.planes(kMostIndex);
    Result roots = make({planes.count, planes.height * planes.width}, kInt32);
    component_roots(set.data<bool>(), planes, data<int32_t>(roots));
    *result = roots.release();
  });
}

AOTITorchError aoti_torch_cpu_hysteresis(AtenTensorHandle x, double low, double high, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image("hysteresis: x", x, kFloating);
    const Planes planes = image.planes(kMostIndex);
    Result out = make(image.sizes(), kBool);
    for_type(image.dtype(), [&](auto zero) {
      using T = decltype(zero);
      hysteresis(image.data<T>(), planes, static_cast<T>(low), static_cast<T>(high), data<bool>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_cheapest_models(AtenTensorHandle models, AtenTensorHandle planes, int32_t epipolar, int64_t count, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument matrices("cheapest_models: models", models, kFloating, {kAny, kAny, 3, 3});
    const int64_t batch = matrices.size(0), per_item = matrices.size(1);
    const Argument points("cheapest_models: planes", planes, matrices.dtype(), {batch, 7, kAny});
    within("cheapest_models: count", count, 1, kMostIndex);
    Result index = make({batch, count}, kInt64);
    for_type(matrices.dtype(), [&](auto zero) {
      using T = decltype(zero);
      cheapest_models(matrices.data<T>(), points.data<T>(), batch, per_item, points.size(2), epipolar != 0, count, data<int64_t>(index));
    });
    *result = index.release();
  });
}

AOTITorchError aoti_torch_cpu_real_roots(AtenTensorHandle coefficients, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument c("real_roots: coefficients", coefficients, kDouble, {kAny, kAny});
    const int64_t degree = within("real_roots: degree", c.size(0) - 1, 0, kMostDegree), count = c.size(1);
    Result roots = make({2, degree, count}, kDouble);
    double* const places = data<double>(roots);
    real_roots(c.data<double>(), degree, count, places, places + degree * count);
    *result = roots.release();
  });
}

AOTITorchError aoti_torch_cpu_gauss_jordan(AtenTensorHandle m, AtenTensorHandle* result) { return like_matrices("gauss_jordan: m", m, result, gauss_jordan); }

AOTITorchError aoti_torch_cpu_spd_inverse(AtenTensorHandle m, AtenTensorHandle* result) { return like_matrices("spd_inverse: m", m, result, spd_inverse); }

AOTITorchError aoti_torch_cpu_high_power(AtenTensorHandle m, int64_t squarings, AtenTensorHandle* result) {
  return like_matrices("high_power: m", m, result, [&](const double* in, Planes planes, double* out) { high_power(in, planes, squarings, out); });
}

AOTITorchError aoti_torch_cpu_sample_patches(AtenTensorHandle pixels, AtenTensorHandle start, AtenTensorHandle height, AtenTensorHandle width,
                                             AtenTensorHandle frames, int64_t side, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source("sample_patches: pixels", pixels, kFloating, {kAny, kAny, kAny});
    const Images images{source.size(0), source.size(1), 1, within("sample_patches: pixels", source.size(2), 0, kMostIndex)};
    const Argument begin("sample_patches: start", start, kInt64, {images.count, kAny});
    const int64_t count = begin.size(1), length = images.width;
    const Argument rows("sample_patches: height", height, kInt64, {images.count, count}), columns("sample_patches: width", width, kInt64, {images.count, count});
    const Argument matrices("sample_patches: frames", frames, source.dtype(), {images.count, count, 2, 3});
    const int64_t *const first = indices(begin, 0, length), *const high = indices(rows, 1, length), *const wide = indices(columns, 1, length);
    for (int64_t i = 0; i < begin.numel(); ++i) within("sample_patches: height * width", high[i] * wide[i], 1, length - first[i]);
    within("sample_patches: side", side, 1, int64_t{1} << 15);
    Result out = make({images.count, images.channels, count, side, side}, source.dtype());
    for_type(source.dtype(), [&](auto zero) {
      using T = decltype(zero);
      sample_patches(source.data<T>(), images, first, high, wide, matrices.data<T>(), count, side, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_strongest_extrema(AtenTensorHandle x, AtenTensorHandle margins, int32_t minima, int64_t count, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values("strongest_extrema: x", x, kFloating, {kAny, kAny, kAny, kAny});
    const Images volumes{values.size(0), values.size(1), values.planes(kMostIndex).height, values.size(3)};
    const Argument distances("strongest_extrema: margins", margins, kInt64, {volumes.channels});
    within("strongest_extrema: count", count, 0, kMostIndex);
    Result places = make({volumes.count, count}, kInt64);
    for_type(values.dtype(), [&](auto zero) {
      using T = decltype(zero);
      strongest_extrema(values.data<T>(), volumes, indices(distances, 0, kMostIndex), minima != 0, count, data<int64_t>(places));
    });
    *result = places.release();
  });
}

AOTITorchError aoti_torch_cpu_squared_distances(AtenTensorHandle a, AtenTensorHandle b, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument rows("squared_distances: a", a, kFloating, {kAny, kAny, kAny});
    const Argument columns("squared_distances: b", b, rows.dtype(), {rows.size(0), kAny, rows.size(2)});
    Result out = make({rows.size(0), rows.size(1), columns.size(1)}, rows.dtype());
    for_type(rows.dtype(), [&](auto zero) {
      using T = decltype(zero);
      squared_distances(rows.data<T>(), columns.data<T>(), rows.size(0), rows.size(1), columns.size(1), rows.size(2), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_two_least(AtenTensorHandle x, int32_t along_rows, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values("two_least: x", x, kFloating, {kAny, kAny, kAny});
    const Planes planes{values.size(0), values.size(1), values.size(2)};
    Result places = make({planes.count, along_rows ? planes.height : planes.width, 2}, kInt64);
    for_type(values.dtype(), [&](auto zero) {
      using T = decltype(zero);
      two_least(values.data<T>(), planes, along_rows != 0, data<int64_t>(places));
    });
    *result = places.release();
  });
}

AOTITorchError aoti_torch_cpu_direction_histograms(AtenTensorHandle patches, AtenTensorHandle window, AtenTensorHandle nearness, int64_t bins,
                                                   AtenTensorHandle* result) {
  return guarded([&] {
    const Argument images("direction_histograms: patches", patches, kFloating, {kAny, kAny, kAny});
    const int64_t size = images.size(1);
    if (images.size(2) != size) refuse(images.name(), "squares", to_text(images.sizes().data(), 3));
    const Argument weights("direction_histograms: window", window, images.dtype(), {size, size});
    const Argument near("direction_histograms: nearness", nearness, images.dtype(), {kAny, size});
    within("direction_histograms: bins", bins, 1, kMostIndex);
    Result out = make({images.size(0), bins, near.size(0), near.size(0)}, images.dtype());
    for_type(images.dtype(), [&](auto zero) {
      using T = decltype(zero);
      direction_histograms(images.data<T>(), images.size(0), size, weights.data<T>(), near.data<T>(), near.size(0), bins, data<T>(out));
    });
    *result = out.release();
  });
}

}  // extern "C"
