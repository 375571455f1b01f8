// OpenCV's calls for the same work as a bundle: the peers with which chiasm is compared.
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
  // The results of the last call: one matrix per image, or per plane. Empty if there is nothing to compare.
  std::function<std::vector<cv::Mat>()> results;
};

// Prepares the inputs in OpenCV's form (HWC matrices, one per image) outside of the timed call, and returns
// the call; nothing if OpenCV has no function for the bundle. `inputs` must outlive the call.
std::optional<Peer> opencv(const std::string& bundle, const std::vector<chiasm::Tensor>& inputs);

}  // namespace peers
