// Collects the texts and pointers of one chiasm_backend_load from the bundle, the method and the caller's
// request.
#include "core/load_call.h"

#include <algorithm>

#include "core/signature_text.h"
#include "core/threads.h"

namespace chiasm::core {
namespace {

std::vector<const char*> names_of(const std::vector<TensorSpec>& tensors) {
  std::vector<const char*> names;
  for (const TensorSpec& tensor : tensors) names.push_back(tensor.name.c_str());
  return names;
}

}  // namespace

LoadCall::LoadCall(const Bundle& bundle, const MethodSpec& method, const Artifact& artifact,
                   const Backend& backend, const LoadRequest& request, int32_t dtype)
    : path_(bundle.file_path(artifact.file)),
      signature_(signature_text(method, bundle.manifest().symbols, dtype)),
      inputs_(names_of(method.inputs)),
      outputs_(names_of(method.outputs)) {
  for (const auto& [key, value] : artifact.options) texts_.push_back(key + "=" + value);
  const size_t artifact_option_count = texts_.size();
  for (std::string& option : request.options_for(backend)) texts_.push_back(std::move(option));
  for (size_t i = 0; i < texts_.size(); ++i)
    (i < artifact_option_count ? artifact_options_ : options_).push_back(texts_[i].c_str());
  artifact_options_.push_back(nullptr);
  options_.push_back(nullptr);

  load_.struct_size = sizeof load_;
  load_.file = path_.c_str();
  load_.format = artifact.format.c_str();
  load_.device_type = request.device_type;
  load_.device_index = request.device_index;
  load_.process_threads = use_num_threads();
  load_.num_threads =
      request.num_threads == 0 ? load_.process_threads : std::min(request.num_threads, load_.process_threads);
  load_.allow_programs = request.programs_refused().empty() ? 1 : 0;
  load_.input_count = static_cast<int32_t>(inputs_.size());
  load_.output_count = static_cast<int32_t>(outputs_.size());
  load_.input_names = inputs_.data();
  load_.output_names = outputs_.data();
  load_.signature = signature_.c_str();
  load_.batched_inputs = method.batched_inputs;
  load_.batched_outputs = method.batched_outputs;
  load_.bundle = bundle.info().path;
  load_.manifest_sha256 = bundle.manifest_sha256().c_str();
  load_.artifact_options = artifact_options_.data();
  load_.options = options_.data();
}

chiasm_backend_load LoadCall::with(const Bytes& bytes) const {
  chiasm_backend_load load = load_;
  load.data = bytes.data();
  load.size = bytes.size();
  return load;
}

}  // namespace chiasm::core
