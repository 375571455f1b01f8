// What OpenCV does for the same work as a bundle: the peers that chiasm is measured beside.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chiasm/chiasm.hpp>

namespace peers {

// Prepares OpenCV's own form of the inputs (HWC matrices, one an image) outside of the timed call, and returns the call.
// Nothing where OpenCV has no function for the bundle. `inputs` must outlive the call.
std::optional<std::function<void()>> opencv(const std::string& bundle, const std::vector<chiasm::Tensor>& inputs);

}  // namespace peers
