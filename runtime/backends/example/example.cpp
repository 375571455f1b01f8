// A backend in one file, to copy from: docs/howto/backend.md explains it.
//
// Its engine is a toy. An artifact is a text of lines `scale NUMBER` and `offset NUMBER`, which are applied
// in their order to each element of the input; the result is the output of the same place.
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "backends/plugin.h"

namespace {

using chiasm::base::Error;
using chiasm::plugin::flag;
using chiasm::plugin::guard;

/** One loaded artifact. Nothing in it changes after it is loaded, so that `run` may be called from several
 *  threads. */
class Program {
 public:
  explicit Program(const chiasm_backend_load& request)
      : tensor_count_(request.output_count), clamp_(flag(request.options, "clamp", false)) {
    if (request.input_count != request.output_count) {
      throw Error(CHIASM_CORRUPT, "the toy engine has an output for each input, the manifest has " +
                                      std::to_string(request.input_count) + " inputs and " +
                                      std::to_string(request.output_count) + " outputs");
    }
    std::istringstream text(std::string(static_cast<const char*>(request.data), request.size));
    std::string word;
    float number = 0;
    while (text >> word) {
      if (!(text >> number) || (word != "scale" && word != "offset")) {
        throw Error(CHIASM_CORRUPT, "expected 'scale NUMBER' or 'offset NUMBER', got '" + word + "'");
      }
      steps_.push_back({word == "scale", number});
    }
  }

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs) const {
    for (int32_t i = 0; i < tensor_count_; ++i) {
      if (inputs[i].dtype != CHIASM_FLOAT32)
        throw Error(CHIASM_UNAVAILABLE, "the toy engine has float32 only");
      const auto* const from = static_cast<const float*>(inputs[i].data);
      auto* const to = static_cast<float*>(outputs[i].data);
      const size_t count = chiasm::base::element_count(outputs[i]);
      for (size_t k = 0; k < count; ++k) to[k] = apply(from[k]);
    }
  }

 private:
  struct Step {
    bool is_scale;
    float number;
  };

  float apply(float value) const {
    for (const Step& step : steps_) value = step.is_scale ? value * step.number : value + step.number;
    return clamp_ ? std::min(std::max(value, 0.0f), 1.0f) : value;
  }

  int32_t tensor_count_;
  bool clamp_;
  std::vector<Step> steps_;
};

// The engine is this file, so there is nothing to open. A real probe opens the engine's library and throws
// Error(CHIASM_UNAVAILABLE, "... is not found: install it with ...") if it cannot.
int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
  return guard(error, [&] {
    info->engine_version = "toy engine 1.0";
    info->has_cuda = 0;
  });
}

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] { *model = new Program(*request); });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options*,
            chiasm_error_text* error) {
  return guard(error, [&] { static_cast<const Program*>(model)->run(inputs, outputs); });
}

void unload(void* model) { delete static_cast<Program*>(model); }

// The text is data: loading it runs nothing that came with the bundle. So it is allowed even if programs are
// not.
constexpr chiasm_backend_format kFormats[] = {{"toy", 0}, {nullptr, 0}};
constexpr chiasm_backend_option kOptions[] = {
    {"clamp", "0 or 1", "1 clamps results to [0, 1]; 0 is the default"}, {nullptr, nullptr, nullptr}};
constexpr int32_t kPriority = 10;  // after chiasm's own: native 300, torch 200, onnx 100

const chiasm_backend backend{sizeof(chiasm_backend),
                             CHIASM_BACKEND_ABI,
                             "example",
                             kPriority,
                             kFormats,
                             1u << CHIASM_CPU,
                             kOptions,
                             probe,
                             nullptr,  // no rank: of several artifacts that fit, the first in the manifest
                             load,
                             run,
                             unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
