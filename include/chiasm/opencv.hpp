/** \file
 *  chiasm and OpenCV. Optional: needs OpenCV's core module, 3.3 or later.
 *
 *  Views in both directions, without a copy, for ops on frames of bytes, (H, W, C): pipelines, and the
 *  catalog's bundles NAME.frames:
 *
 *      cv::Mat frame = cv::imread("frame.png");                       // uint8, H x W x 3, BGR
 *      auto median = chiasm::Bundle::open("filters.median_blur.frames.chiasm").method("forward");
 *      auto out = median.run({chiasm::view(frame)});
 *      cv::Mat smooth = chiasm::to_mat(out[0]);                       // valid as long as `out`
 *
 *  Copies, for ops on images of planes, (B, C, H, W):
 *
 *      chiasm::Planes image = chiasm::planes(frame, 1 / 255.0, true); // float32 in [0, 1], RGB
 *      auto out = sobel.run({image});
 *      cv::Mat edges = chiasm::planes_to_mat(out[0], CV_8U, 255, true);
 */
#ifndef CHIASM_OPENCV_HPP
#define CHIASM_OPENCV_HPP

#include <climits>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "chiasm/chiasm.hpp"

namespace chiasm {

namespace detail {

inline DType dtype_of_depth(int depth) {
  switch (depth) {
    case CV_8U: return DType::UInt8;
    case CV_8S: return DType::Int8;
    case CV_16U: return DType::UInt16;
    case CV_16S: return DType::Int16;
    case CV_32S: return DType::Int32;
    case CV_32F: return DType::Float32;
    case CV_64F: return DType::Float64;
#ifdef CV_16F
    case CV_16F: return DType::Float16;
#endif
    default: break;
  }
  throw Error(CHIASM_INVALID_ARGUMENT, "chiasm has no dtype for cv::Mat depth " + std::to_string(depth));
}

inline int depth_of_dtype(DType dtype) {
  switch (dtype) {
    case DType::Bool:
    case DType::UInt8: return CV_8U;
    case DType::Int8: return CV_8S;
    case DType::UInt16: return CV_16U;
    case DType::Int16: return CV_16S;
    case DType::Int32: return CV_32S;
    case DType::Float32: return CV_32F;
    case DType::Float64: return CV_64F;
#ifdef CV_16F
    case DType::Float16: return CV_16F;
#endif
    default: break;
  }
  throw Error(CHIASM_INVALID_ARGUMENT, std::string("OpenCV has no type for ") + name(dtype));
}

template <class Data>
Tensor view_mat(const cv::Mat& mat, Data* data) {
  if (mat.empty()) throw Error(CHIASM_INVALID_ARGUMENT, "the cv::Mat is empty");
  const DType dtype = dtype_of_depth(mat.depth());
  const size_t element = mat.elemSize1();
  const size_t channels = static_cast<size_t>(mat.channels());
  const size_t dims = static_cast<size_t>(mat.dims);
  const size_t rank = dims + (channels > 1 ? 1 : 0);
  if (rank > CHIASM_MAX_DIMS) throw Error(CHIASM_INVALID_ARGUMENT, "the cv::Mat has too many dimensions");
  int64_t shape[CHIASM_MAX_DIMS], strides[CHIASM_MAX_DIMS];
  for (size_t i = 0; i < dims; ++i) {
    const size_t step = mat.step.p[i];
    if (step % element != 0) {
      throw Error(CHIASM_INVALID_ARGUMENT,
                  "the rows of the cv::Mat do not begin at whole elements: pass a clone()");
    }
    shape[i] = mat.size.p[i];
    strides[i] = static_cast<int64_t>(step / element);
  }
  if (channels > 1) {
    shape[dims] = static_cast<int64_t>(channels);
    strides[dims] = 1;
  }
  return Tensor::strided(data, dtype, Shape(shape, rank), Shape(strides, rank));
}

}  // namespace detail

/** A view of the image: shape (H, W, C), or (H, W) for one channel; the channels are in the Mat's order
 *  (usually BGR).
 *
 *  The view does not keep the Mat's memory alive. A region of interest has gaps between its rows. A run also
 *  accepts a region, as an input and as an output, and copies it (not the whole Mat).
 */
inline Tensor view(cv::Mat& mat) { return detail::view_mat(mat, static_cast<void*>(mat.data)); }
/** The same, read-only: an input, not an output. */
inline Tensor view(const cv::Mat& mat) { return detail::view_mat(mat, static_cast<const void*>(mat.data)); }

/** A Mat that shares the tensor's memory, which must outlive the Mat: (H, W) becomes a Mat with one channel,
 *  (H, W, C) one with C channels. Other shapes throw Error, and so does a read-only tensor, because a Mat is
 *  always writable. bool becomes CV_8U. */
inline cv::Mat to_mat(const Tensor& tensor) {
  const Shape& shape = tensor.shape();
  const Shape strides = tensor.strides();
  const bool has_channels = shape.size() == 3;
  if (tensor.device() != Device::cpu())
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the tensor is not in CPU memory");
  if (tensor.read_only())
    throw Error(CHIASM_INVALID_ARGUMENT,
                "to_mat: the tensor is read-only, a cv::Mat is writable: copy the tensor first");
  if (shape.size() != 2 && !has_channels) {
    throw Error(CHIASM_INVALID_ARGUMENT,
                "to_mat: expected a tensor of shape (H, W) or (H, W, C), got one of " +
                    std::to_string(shape.size()) + " dimensions");
  }
  const int64_t channels = has_channels ? shape[2] : 1;
  if (channels < 1 || channels > CV_CN_MAX) {
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: expected 1 to " + std::to_string(CV_CN_MAX) +
                                             " channels, got " + std::to_string(channels) +
                                             " (is the tensor (C, H, W)?)");
  }
  for (const int64_t size : {shape[0], shape[1]}) {
    if (size < 0 || size > INT_MAX)
      throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: expected 0 to " + std::to_string(INT_MAX) +
                                               " rows and columns, got " + std::to_string(size));
  }
  const bool dense_pixels =
      (!has_channels || channels == 1 || strides[2] == 1) && (shape[1] <= 1 || strides[1] == channels);
  if (!dense_pixels)
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the pixels of a row do not follow each other in memory");
  // A Mat's step is not negative, and 0 stands for rows without gaps
  if (shape[0] > 1 && strides[0] < shape[1] * channels)
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the rows share memory or lie backwards: their stride is " +
                                             std::to_string(strides[0]) + " elements, expected at least " +
                                             std::to_string(shape[1] * channels));
  const int type = CV_MAKETYPE(detail::depth_of_dtype(tensor.dtype()), static_cast<int>(channels));
  const size_t step =
      shape[0] <= 1 ? size_t{cv::Mat::AUTO_STEP} : static_cast<size_t>(strides[0]) * CV_ELEM_SIZE1(type);
  return cv::Mat(static_cast<int>(shape[0]), static_cast<int>(shape[1]), type, tensor.data(), step);
}
/** Deleted: the memory would be freed before the Mat is used. Keep the Outputs in a variable. */
cv::Mat to_mat(const TemporaryTensor& tensor) = delete;

/** An image as planes, a tensor of shape (1, C, H, W) that owns its memory. */
class Planes final {
 public:
  Planes(std::vector<unsigned char> memory, DType dtype, Shape shape)
      : memory_(std::move(memory)), dtype_(dtype), shape_(shape) {}

  DType dtype() const { return dtype_; }
  const Shape& shape() const { return shape_; }
  /** A view, valid as long as these Planes. */
  Tensor tensor() const& { return Tensor(static_cast<const void*>(memory_.data()), dtype_, shape_); }
  Tensor tensor() & { return Tensor(static_cast<void*>(memory_.data()), dtype_, shape_); }
  operator Tensor() const& { return tensor(); }

 private:
  std::vector<unsigned char> memory_;
  DType dtype_;
  Shape shape_;
};

namespace detail {

inline Planes split_mat(const cv::Mat& mat, bool swap_rb) {
  if (mat.empty()) throw Error(CHIASM_INVALID_ARGUMENT, "planes: the cv::Mat is empty");
  if (mat.dims != 2)
    throw Error(CHIASM_INVALID_ARGUMENT,
                "planes: expected a cv::Mat of 2 dimensions, got " + std::to_string(mat.dims));
  const int channels = mat.channels();
  if (swap_rb && channels < 3) {
    throw Error(CHIASM_INVALID_ARGUMENT,
                "planes: swap_rb is for 3 or 4 channels, the cv::Mat has " + std::to_string(channels));
  }
  const DType dtype = dtype_of_depth(mat.depth());
  const size_t plane_bytes = static_cast<size_t>(mat.rows) * static_cast<size_t>(mat.cols) * mat.elemSize1();
  std::vector<unsigned char> memory(plane_bytes * static_cast<size_t>(channels));
  std::vector<cv::Mat> targets;
  for (int c = 0; c < channels; ++c) {
    const int to = swap_rb && c < 3 ? 2 - c : c;
    targets.emplace_back(mat.rows, mat.cols, mat.depth(),
                         memory.data() + plane_bytes * static_cast<size_t>(to));
  }
  cv::split(mat, targets.data());
  return Planes(std::move(memory), dtype, Shape{1, channels, mat.rows, mat.cols});
}

}  // namespace detail

/** The image as planes of its own element type: (H, W, C) becomes (1, C, H, W). Copies. */
inline Planes planes(const cv::Mat& mat) { return detail::split_mat(mat, false); }

/** The same as float32, each value times `scale` (1 / 255.0 for bytes), with the first and the third channel
 *  swapped if `swap_rb`: OpenCV has BGR, ops take RGB. The arguments are those of cv::dnn::blobFromImage. */
inline Planes planes(const cv::Mat& mat, double scale, bool swap_rb = false) {
  cv::Mat scaled;
  if (!mat.empty()) mat.convertTo(scaled, CV_32F, scale);
  return detail::split_mat(scaled, swap_rb);
}

/** Image `index` of a tensor of shape (C, H, W) or (B, C, H, W) as a new Mat (H, W, C): each value is
 *  multiplied by `scale` and rounded and saturated to `depth` (CV_8U, ...; negative: the tensor's own); the
 *  first and the third channel are swapped if `swap_rb`. */
inline cv::Mat planes_to_mat(const Tensor& tensor, int depth = -1, double scale = 1, bool swap_rb = false,
                             int64_t index = 0) {
  const Shape& shape = tensor.shape();
  if (shape.size() != 3 && shape.size() != 4) {
    throw Error(CHIASM_INVALID_ARGUMENT,
                "planes_to_mat: expected a tensor of shape (C, H, W) or (B, C, H, W), got one of " +
                    std::to_string(shape.size()) + " dimensions");
  }
  if (tensor.device() != Device::cpu())
    throw Error(CHIASM_INVALID_ARGUMENT, "planes_to_mat: the tensor is not in CPU memory");
  if (!tensor.is_contiguous()) throw Error(CHIASM_INVALID_ARGUMENT, "planes_to_mat: the tensor is not dense");
  const size_t first = shape.size() - 3;
  const int64_t batch = first == 1 ? shape[0] : 1, channels = shape[first], rows = shape[first + 1],
                cols = shape[first + 2];
  if (index < 0 || index >= batch) {
    throw Error(CHIASM_INVALID_ARGUMENT, "planes_to_mat: there is no image " + std::to_string(index) +
                                             ", only " + std::to_string(batch));
  }
  if (rows < 0 || cols < 0 || rows > INT_MAX || cols > INT_MAX) {
    throw Error(CHIASM_INVALID_ARGUMENT, "planes_to_mat: expected sizes from 0 to 2^31 - 1, got " +
                                             std::to_string(rows) + " x " + std::to_string(cols));
  }
  if (channels < 1 || channels > CV_CN_MAX) {
    throw Error(CHIASM_INVALID_ARGUMENT, "planes_to_mat: expected 1 to " + std::to_string(CV_CN_MAX) +
                                             " channels, got " + std::to_string(channels) +
                                             " (is the tensor (H, W, C)? then use to_mat)");
  }
  if (swap_rb && channels < 3) {
    throw Error(CHIASM_INVALID_ARGUMENT,
                "planes_to_mat: swap_rb is for 3 or 4 channels, the tensor has " + std::to_string(channels));
  }
  const int own_depth = detail::depth_of_dtype(tensor.dtype());
  if (rows == 0 || cols == 0) {
    return cv::Mat(static_cast<int>(rows), static_cast<int>(cols),
                   CV_MAKETYPE(depth < 0 ? own_depth : depth, static_cast<int>(channels)));
  }
  const size_t plane_bytes = static_cast<size_t>(rows * cols) * static_cast<size_t>(CV_ELEM_SIZE1(own_depth));
  // cv::merge only reads them.
  auto* const data =
      static_cast<unsigned char*>(const_cast<void*>(static_cast<const void*>(tensor.c_tensor().data))) +
      plane_bytes * static_cast<size_t>(channels * index);
  std::vector<cv::Mat> sources;
  for (int64_t c = 0; c < channels; ++c) {
    const int64_t from = swap_rb && c < 3 ? 2 - c : c;
    sources.emplace_back(static_cast<int>(rows), static_cast<int>(cols), own_depth,
                         data + plane_bytes * static_cast<size_t>(from));
  }
  cv::Mat merged;
  cv::merge(sources, merged);
  if (depth >= 0 || scale != 1) merged.convertTo(merged, depth < 0 ? own_depth : depth, scale);
  return merged;
}

}  // namespace chiasm

#endif  // CHIASM_OPENCV_HPP
