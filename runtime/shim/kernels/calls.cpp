// How AOTInductor's code calls the kernels: as the operators chiasm::... of python/chiasm/primitives/kernels.py, which has these
// declarations too.
#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include "../tensor.h"
#include "kernels.h"

using namespace chiasm::shim;
using namespace chiasm::kernels;

namespace {

using Result = std::unique_ptr<AtenTensorOpaque>;

// A dense tensor among the arguments.
class Argument {
 public:
  explicit Argument(AtenTensorHandle handle) : tensor_(dense(*handle, owner_)) {}
  template <class T>
  const T* data() const { return reinterpret_cast<const T*>(tensor_.data()); }
  const AtenTensorOpaque& operator*() const { return tensor_; }
  int64_t size(size_t i) const { return tensor_.sizes[i]; }

 private:
  Result owner_;
  const AtenTensorOpaque& tensor_;
};

Result make(const Dims& sizes, int32_t dtype) { return Result(allocate(sizes, dense_strides(sizes), dtype)); }

template <class T>
T* data(Result& tensor) { return reinterpret_cast<T*>(tensor->data()); }

// The planes of (..., H, W).
Planes planes_of(const AtenTensorOpaque& tensor) {
  const size_t n = tensor.sizes.size();
  Planes planes{1, tensor.sizes[n - 2], tensor.sizes[n - 1]};
  for (size_t i = 0; i + 2 < n; ++i) planes.count *= tensor.sizes[i];
  return planes;
}

// Calls body(T{}) with the floating-point type.
template <class Body>
void for_type(int32_t dtype, const Body& body) {
  switch (dtype) {
    case kFloat: return body(float{});
    case kDouble: return body(double{});
  }
  throw std::runtime_error("a kernel is not there for element type " + std::to_string(dtype));
}

// Has body(image, planes, its data, the result's data) make a tensor of x's sizes and type.
template <class Body>
AOTITorchError like_image(AtenTensorHandle x, AtenTensorHandle* result, const Body& body) {
  return guarded([&] {
    const Argument image(x);
    Result out = make((*image).sizes, (*image).dtype);
    for_type((*image).dtype, [&](auto zero) {
      using T = decltype(zero);
      body(image, planes_of(*image), image.data<T>(), data<T>(out));
    });
    *result = out.release();
  });
}

// Has body(matrices, planes, the result's data) make matrices like m.
template <class Body>
AOTITorchError like_matrices(AtenTensorHandle m, AtenTensorHandle* result, const Body& body) {
  return guarded([&] {
    const Argument matrices(m);
    const Planes planes = planes_of(*matrices);
    if ((*matrices).dtype != kDouble || planes.height != planes.width || planes.height > kMostRows)
      throw std::runtime_error("a kernel for matrices: expected float64 and at most 16 rows");
    Result out = make((*matrices).sizes, kDouble);
    body(matrices.data<double>(), planes, data<double>(out));
    *result = out.release();
  });
}

// Has taps(T{}, size, new size) say how each axis of an image is resampled.
template <class MakeTaps>
AOTITorchError resampled(AtenTensorHandle x, int64_t height, int64_t width, AtenTensorHandle* result, const MakeTaps& taps) {
  return guarded([&] {
    const Argument image(x);
    Result out = make({image.size(0), image.size(1), height, width}, (*image).dtype);
    for_type((*image).dtype, [&](auto zero) {
      resample(image.data<decltype(zero)>(), planes_of(*image), taps(zero, image.size(2), height), taps(zero, image.size(3), width), data<decltype(zero)>(out));
    });
    *result = out.release();
  });
}

// A frame (H, W, 3) of bytes.
const uint8_t* frame_of(const Argument& image) {
  if ((*image).dtype != kUint8 || image.size(1) < 2) throw std::runtime_error("a kernel for frames: expected uint8, two pixels wide or more");
  return image.data<uint8_t>();
}

}  // namespace

extern "C" {

AOTITorchError aoti_torch_cpu_frame_to_grey(AtenTensorHandle frame, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image(frame);
    Result out = make({1, 1, image.size(0), image.size(1)}, kFloat);
    frame_to_grey(frame_of(image), image.size(0) * image.size(1), data<float>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_resize_frame(AtenTensorHandle frame, int64_t height, int64_t width, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image(frame);
    Result out = make({1, 3, height, width}, kFloat);
    resize_frame(frame_of(image), image.size(0), image.size(1), height, width, data<float>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_separable(AtenTensorHandle x, AtenTensorHandle kernel_y, AtenTensorHandle kernel_x, int64_t border, double scale, double centre,
                                        AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument& image, const Planes& planes, const T* in, T* out) {
    const Argument column(kernel_y), row(kernel_x);
    const int64_t channels = image.size(1);
    separable(in, planes, column.data<T>(), column.size(1), column.size(0) == 1 ? 0 : channels, row.data<T>(), row.size(1),
              row.size(0) == 1 ? 0 : channels, Border(border), static_cast<T>(scale), static_cast<T>(centre), out);
  });
}

AOTITorchError aoti_torch_cpu_bilateral(AtenTensorHandle x, AtenTensorHandle guide, AtenTensorHandle nearness, AtenTensorHandle falloff, int64_t border,
                                        int32_t squares, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument& image, const Planes&, const T* in, T* out) {
    const Argument guidance(guide), near(nearness), fall(falloff);
    const Planes images{image.size(0), image.size(2), image.size(3)};
    bilateral(in, image.size(1), guidance.data<T>(), guidance.size(1), guidance.size(0) == 1, images, near.data<T>(), near.size(0) == 1, near.size(1),
              near.size(2), fall.data<T>(), fall.size(0) == 1, Border(border), squares != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_rectangle_extreme(AtenTensorHandle x, int64_t rows, int64_t columns, int64_t border, double value, int32_t largest,
                                                AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) {
    rectangle_extreme(in, planes, rows, columns, Border(border), static_cast<T>(value), largest != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_structured_extreme(AtenTensorHandle x, AtenTensorHandle heights, int64_t row, int64_t column, int64_t border, double value,
                                                 double absent, int32_t largest, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) {
    const Argument window(heights);
    structured_extreme(in, planes, window.data<T>(), window.size(0), window.size(1), row, column, Border(border), static_cast<T>(value),
                       static_cast<T>(absent), largest != 0, out);
  });
}

AOTITorchError aoti_torch_cpu_structured_range(AtenTensorHandle x, AtenTensorHandle high_window, AtenTensorHandle low_window, int64_t row, int64_t column,
                                               int64_t border, double high_value, double low_value, double absent, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) {
    const Argument high(high_window), low(low_window);
    structured_range(in, planes, high.data<T>(), low.data<T>(), high.size(0), high.size(1), row, column, Border(border), static_cast<T>(high_value),
                     static_cast<T>(low_value), static_cast<T>(absent), out);
  });
}

AOTITorchError aoti_torch_cpu_median3x3(AtenTensorHandle x, int64_t border, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { median3x3(in, planes, Border(border), out); });
}

AOTITorchError aoti_torch_cpu_integral(AtenTensorHandle x, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { integral(in, planes, out); });
}

AOTITorchError aoti_torch_cpu_sample(AtenTensorHandle src, AtenTensorHandle x, AtenTensorHandle y, int64_t mode, int64_t padding, int32_t corners,
                                     AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source(src), column(x), row(y);
    const Images images{source.size(0), source.size(1), source.size(2), source.size(3)};
    Result out = make({images.count, images.channels, column.size(1), column.size(2)}, (*source).dtype);
    for_type((*source).dtype, [&](auto zero) {
      using T = decltype(zero);
      sample(source.data<T>(), images, column.data<T>(), row.data<T>(), column.size(1), column.size(2), Interpolation(mode), Padding(padding),
             corners != 0, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_sample_projective(AtenTensorHandle src, AtenTensorHandle matrix, int64_t height, int64_t width, int64_t mode, int64_t padding,
                                                int32_t corners, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source(src), matrices(matrix);
    const Images images{source.size(0), source.size(1), source.size(2), source.size(3)};
    Result out = make({images.count, images.channels, height, width}, (*source).dtype);
    for_type((*source).dtype, [&](auto zero) {
      using T = decltype(zero);
      sample_projective(source.data<T>(), images, matrices.data<T>(), height, width, Interpolation(mode), Padding(padding), corners != 0, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_resize(AtenTensorHandle x, int64_t height, int64_t width, int64_t filter, int32_t corners, int32_t antialias,
                                     AtenTensorHandle* result) {
  return resampled(x, height, width, result, [&]<class T>(T, int64_t in, int64_t out) { return resize_taps<T>(in, out, Filter(filter), corners != 0, antialias != 0); });
}

AOTITorchError aoti_torch_cpu_resize_blurred(AtenTensorHandle x, AtenTensorHandle kernel, int64_t height, int64_t width, int32_t corners, int64_t border,
                                             int32_t before, AtenTensorHandle* result) {
  return resampled(x, height, width, result, [&]<class T>(T, int64_t in, int64_t out) {
    const Argument given(kernel);
    const std::vector<T> weights(given.data<T>(), given.data<T>() + given.size(0));
    const Taps<T> taps = resize_taps<T>(in, out, Filter::kBilinear, corners != 0, false);
    return before ? blurred_before(taps, weights, Border(border), in) : blurred_after(taps, weights, Border(border));
  });
}

AOTITorchError aoti_torch_cpu_ridges(AtenTensorHandle x, double eps, AtenTensorHandle* result) {
  return like_image(x, result, [&]<class T>(const Argument&, const Planes& planes, const T* in, T* out) { ridges(in, planes, static_cast<T>(eps), out); });
}

AOTITorchError aoti_torch_cpu_extents(AtenTensorHandle x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values(x);
    Result out = make({2, values.size(0), 1}, (*values).dtype);
    for_type((*values).dtype, [&](auto zero) {
      using T = decltype(zero);
      extents(values.data<T>(), values.size(0), values.size(1), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_to_levels(AtenTensorHandle x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values(x);
    Result levels = make((*values).sizes, kUint8);
    for_type((*values).dtype, [&](auto zero) {
      using T = decltype(zero);
      to_levels(values.data<T>(), (*values).numel(), data<uint8_t>(levels));
    });
    *result = levels.release();
  });
}

AOTITorchError aoti_torch_cpu_bin_counts(AtenTensorHandle x, AtenTensorHandle low, AtenTensorHandle span, int64_t bins, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values(x), least(low), width(span);
    const int64_t rows = values.size(0), n = values.size(1);
    Result counts = make({rows, bins}, kInt32);
    for_type((*values).dtype, [&](auto zero) {
      using T = decltype(zero);
      bin_counts(values.data<T>(), least.data<T>(), width.data<T>(), rows, n, bins, data<int32_t>(counts));
    });
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_count_each(AtenTensorHandle index, int64_t bins, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument numbers(index);
    const int64_t rows = numbers.size(0), n = numbers.size(1);
    Result counts = make({rows, bins}, kInt32);
    if ((*numbers).dtype == kUint8) {
      count_each(numbers.data<uint8_t>(), rows, n, bins, data<int32_t>(counts));
    } else if ((*numbers).dtype == kInt32) {
      count_each(numbers.data<int32_t>(), rows, n, bins, data<int32_t>(counts));
    } else {
      throw std::runtime_error("count_each is not there for element type " + std::to_string((*numbers).dtype));
    }
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_look_up(AtenTensorHandle table, AtenTensorHandle index, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument entries(table), levels(index);
    if (entries.size(1) != 256 || (*levels).dtype != kUint8) throw std::runtime_error("look_up: expected a table of 256 entries and uint8");
    Result out = make((*levels).sizes, (*entries).dtype);
    for_type((*entries).dtype, [&](auto zero) {
      using T = decltype(zero);
      look_up(entries.data<T>(), levels.data<uint8_t>(), levels.size(0), levels.size(1), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_tile_counts(AtenTensorHandle levels, int64_t tile_y, int64_t tile_x, int64_t tiles_y, int64_t tiles_x, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image(levels);
    Result counts = make({image.size(0), tiles_y * tiles_x, 256}, kInt32);
    tile_counts(image.data<uint8_t>(), planes_of(*image), tile_y, tile_x, tiles_y, tiles_x, data<int32_t>(counts));
    *result = counts.release();
  });
}

AOTITorchError aoti_torch_cpu_blend_curves(AtenTensorHandle table, int64_t tiles_x, AtenTensorHandle levels, AtenTensorHandle first_y, AtenTensorHandle second_y,
                                           AtenTensorHandle weight_y, AtenTensorHandle first_x, AtenTensorHandle second_x, AtenTensorHandle weight_x,
                                           AtenTensorHandle* result) {
  return guarded([&] {
    const Argument curves(table), image(levels), y0(first_y), y1(second_y), wy(weight_y), x0(first_x), x1(second_x), wx(weight_x);
    Result out = make((*image).sizes, kUint8);
    blend_curves(curves.data<float>(), curves.size(1) / 256, tiles_x, image.data<uint8_t>(), planes_of(*image), y0.data<int64_t>(), y1.data<int64_t>(),
                 wy.data<float>(), x0.data<int64_t>(), x1.data<int64_t>(), wx.data<float>(), data<uint8_t>(out));
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_component_roots(AtenTensorHandle mask, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument set(mask);
    Result roots = make({set.size(0), set.size(1) * set.size(2)}, kInt32);
    component_roots(set.data<bool>(), planes_of(*set), data<int32_t>(roots));
    *result = roots.release();
  });
}

AOTITorchError aoti_torch_cpu_hysteresis(AtenTensorHandle x, double low, double high, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument image(x);
    Result out = make((*image).sizes, kBool);
    for_type((*image).dtype, [&](auto zero) {
      using T = decltype(zero);
      hysteresis(image.data<T>(), planes_of(*image), static_cast<T>(low), static_cast<T>(high), data<bool>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_cheapest_models(AtenTensorHandle models, AtenTensorHandle planes, int32_t epipolar, int64_t count, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument matrices(models), points(planes);
    Result index = make({matrices.size(0), count}, kInt64);
    for_type((*matrices).dtype, [&](auto zero) {
      using T = decltype(zero);
      cheapest_models(matrices.data<T>(), points.data<T>(), matrices.size(0), matrices.size(1), points.size(2), epipolar != 0, count, data<int64_t>(index));
    });
    *result = index.release();
  });
}

AOTITorchError aoti_torch_cpu_real_roots(AtenTensorHandle coefficients, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument c(coefficients);
    const int64_t degree = c.size(0) - 1, count = c.size(1);
    if (degree > kMostDegree || (*c).dtype != kDouble) throw std::runtime_error("real_roots: expected float64 and a degree of at most 16");
    Result roots = make({2, degree, count}, kDouble);
    double* const places = data<double>(roots);
    real_roots(c.data<double>(), degree, count, places, places + degree * count);
    *result = roots.release();
  });
}

AOTITorchError aoti_torch_cpu_gauss_jordan(AtenTensorHandle m, AtenTensorHandle* result) { return like_matrices(m, result, gauss_jordan); }

AOTITorchError aoti_torch_cpu_spd_inverse(AtenTensorHandle m, AtenTensorHandle* result) { return like_matrices(m, result, spd_inverse); }

AOTITorchError aoti_torch_cpu_high_power(AtenTensorHandle m, int64_t squarings, AtenTensorHandle* result) {
  return like_matrices(m, result, [&](const double* in, Planes planes, double* out) { high_power(in, planes, squarings, out); });
}

AOTITorchError aoti_torch_cpu_sample_patches(AtenTensorHandle pixels, AtenTensorHandle start, AtenTensorHandle height, AtenTensorHandle width,
                                             AtenTensorHandle frames, int64_t side, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument source(pixels), begin(start), rows(height), columns(width), matrices(frames);
    const Images images{source.size(0), source.size(1), 1, source.size(2)};
    const int64_t count = begin.size(1);
    Result out = make({images.count, images.channels, count, side, side}, (*source).dtype);
    for_type((*source).dtype, [&](auto zero) {
      using T = decltype(zero);
      sample_patches(source.data<T>(), images, begin.data<int64_t>(), rows.data<int64_t>(), columns.data<int64_t>(), matrices.data<T>(), count, side, data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_strongest_extrema(AtenTensorHandle x, AtenTensorHandle margins, int32_t minima, int64_t count, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values(x), distances(margins);
    const Images volumes{values.size(0), values.size(1), values.size(2), values.size(3)};
    Result places = make({volumes.count, count}, kInt64);
    for_type((*values).dtype, [&](auto zero) {
      using T = decltype(zero);
      strongest_extrema(values.data<T>(), volumes, distances.data<int64_t>(), minima != 0, count, data<int64_t>(places));
    });
    *result = places.release();
  });
}

AOTITorchError aoti_torch_cpu_squared_distances(AtenTensorHandle a, AtenTensorHandle b, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument rows(a), columns(b);
    Result out = make({rows.size(0), rows.size(1), columns.size(1)}, (*rows).dtype);
    for_type((*rows).dtype, [&](auto zero) {
      using T = decltype(zero);
      squared_distances(rows.data<T>(), columns.data<T>(), rows.size(0), rows.size(1), columns.size(1), rows.size(2), data<T>(out));
    });
    *result = out.release();
  });
}

AOTITorchError aoti_torch_cpu_two_least(AtenTensorHandle x, int32_t along_rows, AtenTensorHandle* result) {
  return guarded([&] {
    const Argument values(x);
    const Planes planes = planes_of(*values);
    Result places = make({planes.count, along_rows ? planes.height : planes.width, 2}, kInt64);
    for_type((*values).dtype, [&](auto zero) {
      using T = decltype(zero);
      two_least(values.data<T>(), planes, along_rows != 0, data<int64_t>(places));
    });
    *result = places.release();
  });
}

AOTITorchError aoti_torch_cpu_direction_histograms(AtenTensorHandle patches, AtenTensorHandle window, AtenTensorHandle nearness, int64_t bins,
                                                   AtenTensorHandle* result) {
  return guarded([&] {
    const Argument images(patches), weights(window), near(nearness);
    Result out = make({images.size(0), bins, near.size(0), near.size(0)}, (*images).dtype);
    for_type((*images).dtype, [&](auto zero) {
      using T = decltype(zero);
      direction_histograms(images.data<T>(), images.size(0), images.size(3), weights.data<T>(), near.data<T>(), near.size(0), bins, data<T>(out));
    });
    *result = out.release();
  });
}

}  // extern "C"
