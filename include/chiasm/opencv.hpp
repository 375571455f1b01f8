/** chiasm and OpenCV: views in both directions, no copies. Optional: needs OpenCV's core module, 3.3 or later.
 *
 *      cv::Mat frame = cv::imread("frame.png");                       // uint8, H x W x 3, BGR
 *      auto out = pipeline.run({chiasm::view(frame)});
 *      cv::Mat edges = chiasm::to_mat(out[0]);                        // valid as long as `out`
 */
#ifndef CHIASM_OPENCV_HPP
#define CHIASM_OPENCV_HPP

#include <climits>
#include <opencv2/core.hpp>
#include <string>

#include "chiasm/chiasm.hpp"

namespace chiasm {

namespace detail {

inline DType dtype_of_depth(int depth) {
  switch (depth) {
    case CV_8U: return DType::UInt8;
    case CV_8S: return DType::Int8;
    case CV_16S: return DType::Int16;
    case CV_32S: return DType::Int32;
    case CV_32F: return DType::Float32;
    case CV_64F: return DType::Float64;
#ifdef CV_16F
    case CV_16F: return DType::Float16;
#endif
    default: break;
  }
  if (depth == CV_16U) throw Error(CHIASM_INVALID_ARGUMENT, "chiasm has no dtype uint16: convert the cv::Mat with convertTo");
  throw Error(CHIASM_INVALID_ARGUMENT, "chiasm has no dtype for cv::Mat depth " + std::to_string(depth));
}

inline int depth_of_dtype(DType dtype) {
  switch (dtype) {
    case DType::Bool:
    case DType::UInt8: return CV_8U;
    case DType::Int8: return CV_8S;
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
      throw Error(CHIASM_INVALID_ARGUMENT, "the rows of the cv::Mat do not begin at whole elements: pass a clone()");
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

/** A view of the image: shape (H, W, C), or (H, W) for one channel; the channels in the order of the Mat (BGR as a rule).
 *
 *  The view does not keep the Mat's memory alive. A region of interest has gaps between its rows; the view says so in its
 *  strides, and run refuses it: pass `roi.clone()`.
 */
inline Tensor view(cv::Mat& mat) { return detail::view_mat(mat, static_cast<void*>(mat.data)); }
/** The same, read-only: an input, not an output. */
inline Tensor view(const cv::Mat& mat) { return detail::view_mat(mat, static_cast<const void*>(mat.data)); }

/** A Mat that shares the tensor's memory, which must outlive it: of (H, W) with one channel, of (H, W, C) with C channels.
 *  Other shapes throw Error, and so does a read-only tensor, because whoever has a Mat may write to it. bool comes as CV_8U. */
inline cv::Mat to_mat(const Tensor& tensor) {
  const Shape& shape = tensor.shape();
  const Shape strides = tensor.strides();
  const bool has_channels = shape.size() == 3;
  if (tensor.device() != Device::cpu()) throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the tensor is not in CPU memory");
  if (tensor.read_only()) throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the tensor is read-only, a cv::Mat is writable: copy the tensor first");
  if (shape.size() != 2 && !has_channels) {
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: expected a tensor of shape (H, W) or (H, W, C), got one of " +
                                             std::to_string(shape.size()) + " dimensions");
  }
  const int64_t channels = has_channels ? shape[2] : 1;
  if (channels < 1 || channels > CV_CN_MAX || shape[0] > INT_MAX || shape[1] > INT_MAX) {
    throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: expected at most " + std::to_string(CV_CN_MAX) + " channels, got " +
                                             std::to_string(channels) + " (is the tensor (C, H, W)?)");
  }
  const bool dense_pixels = (!has_channels || channels == 1 || strides[2] == 1) && (shape[1] <= 1 || strides[1] == channels);
  if (!dense_pixels) throw Error(CHIASM_INVALID_ARGUMENT, "to_mat: the pixels of a row do not follow each other in memory");
  const int type = CV_MAKETYPE(detail::depth_of_dtype(tensor.dtype()), static_cast<int>(channels));
  const size_t step = shape[0] <= 1 ? size_t{cv::Mat::AUTO_STEP} : static_cast<size_t>(strides[0]) * CV_ELEM_SIZE1(type);
  return cv::Mat(static_cast<int>(shape[0]), static_cast<int>(shape[1]), type, tensor.data(), step);
}
/** The memory would be gone before the Mat is used: keep the Outputs in a variable. */
cv::Mat to_mat(const TemporaryTensor& tensor) = delete;

}  // namespace chiasm

#endif  // CHIASM_OPENCV_HPP
