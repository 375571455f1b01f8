// What OpenCV does for the same work as a bundle: the peers that chiasm is measured beside.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chiasm/chiasm.hpp>
#include <opencv2/core.hpp>

namespace peers {

struct Peer {
  std::function<void()> call;
  // What the last call made: a matrix an image, or one a plane. Empty where there is nothing to compare.
  std::function<std::vector<cv::Mat>()> results;
};

// Prepares OpenCV's own form of the inputs (HWC matrices, one an image) outside of the timed call, and
// returns the call. Nothing where OpenCV has no function for the bundle. `inputs` must outlive the call.
std::optional<Peer> opencv(const std::string& bundle, const std::vector<chiasm::Tensor>& inputs);

}  // namespace peers
