// Shared code of the peers: the images of a batch as matrices, and matrices for results.
#pragma once

#include <map>
#include <memory>

#include <opencv2/imgproc.hpp>

#include "../opencv_peers.hpp"

namespace peers {

using Inputs = std::vector<chiasm::Tensor>;
using Table = std::map<std::string, std::function<Peer(const Inputs&)>>;

Table color();
Table enhance();
Table filters();
Table geometry();
Table morphology();
Table pipelines();

// The planes of a tensor (B, C, H, W), without a copy.
inline std::vector<cv::Mat> planes(const chiasm::Tensor& tensor) {
  const auto& s = tensor.shape();
  const bool bytes = tensor.dtype() == chiasm::DType::UInt8;
  std::vector<cv::Mat> result;
  for (int64_t i = 0; i < s[0] * s[1]; ++i) {
    auto* start = static_cast<char*>(const_cast<void*>(static_cast<const void*>(tensor.data()))) +
                  i * s[2] * s[3] * (bytes ? 1 : 4);
    result.emplace_back(int(s[2]), int(s[3]), bytes ? CV_8U : CV_32F, start);
  }
  return result;
}

// The same as bytes, for functions that OpenCV has for bytes only; `scale` maps floating point to 0..255.
inline std::vector<cv::Mat> byte_planes(const chiasm::Tensor& tensor, double scale) {
  std::vector<cv::Mat> result;
  for (const auto& plane : planes(tensor))
    plane.convertTo(result.emplace_back(), CV_8U, plane.depth() == CV_8U ? 1 : scale);
  return result;
}

// The images of a tensor (B, C, H, W) as HWC matrices, given its planes.
inline std::vector<cv::Mat> images(const std::vector<cv::Mat>& planes, int64_t channels) {
  std::vector<cv::Mat> result;
  for (auto plane = planes.begin(); plane != planes.end(); plane += channels)
    cv::merge(&*plane, size_t(channels), result.emplace_back());
  return result;
}

inline std::vector<cv::Mat> images(const chiasm::Tensor& tensor) {
  return images(planes(tensor), tensor.shape()[1]);
}

struct Batch {
  std::vector<cv::Mat> in, out, scratch, more, bytes;

  explicit Batch(std::vector<cv::Mat> matrices)
      : in(std::move(matrices)), out(in.size()), scratch(in.size()), more(in.size()), bytes(in.size()) {}
};

// `body(batch, i)` computes batch.out[i] from batch.in[i].
template <class Body>
Peer per_image(std::vector<cv::Mat> in, Body body) {
  auto batch = std::make_shared<Batch>(std::move(in));
  const auto call = [batch, body] {
    for (size_t i = 0; i < batch->in.size(); ++i) body(*batch, i);
  };
  return {call, [batch] { return batch->out; }};
}

// A function that OpenCV has for bytes only, on float32 like chiasm's: the conversions to bytes (of values
// from 0 to 1 / scale) and back are part of the call. `body(bytes, result, scratch)` works on bytes.
template <class Body>
Peer per_byte_image(std::vector<cv::Mat> in, double scale, Body body) {
  return per_image(std::move(in), [scale, body](Batch& b, size_t i) {
    b.in[i].convertTo(b.scratch[i], CV_8U, scale);
    body(b.scratch[i], b.bytes[i], b.more[i]);
    b.bytes[i].convertTo(b.out[i], CV_32F, 1 / scale);
  });
}

inline float first(const chiasm::Tensor& tensor) { return tensor.data<const float>()[0]; }

inline cv::Scalar channels(const chiasm::Tensor& tensor) {
  const float* data = tensor.data<const float>();
  return {data[0], data[1], data[2]};
}

inline cv::Mat frame(const chiasm::Tensor& tensor) {
  return cv::Mat(int(tensor.shape()[0]), int(tensor.shape()[1]), CV_8UC3, const_cast<void*>(tensor.data()));
}

}  // namespace peers
