#include "triton/model.h"

#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "triton/errors.h"

namespace chiasm::triton {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct DeleteMessage {
  void operator()(TRITONSERVER_Message* message) const noexcept {
    log_failure(TRITONSERVER_MessageDelete(message));
  }
};
struct DeleteParameter {
  void operator()(TRITONSERVER_Parameter* parameter) const noexcept {
    TRITONSERVER_ParameterDelete(parameter);
  }
};
using Message = std::unique_ptr<TRITONSERVER_Message, DeleteMessage>;

json read_config(TRITONBACKEND_Model* model) {
  TRITONSERVER_Message* made = nullptr;
  check(TRITONBACKEND_ModelConfig(model, 1, &made));
  const Message message(made);
  const char* text = nullptr;
  size_t size = 0;
  check(TRITONSERVER_MessageSerializeToJson(message.get(), &text, &size));
  return json::parse(text, text + size);
}

void write_config(TRITONBACKEND_Model* model, const json& config) {
  const std::string text = config.dump();
  TRITONSERVER_Message* made = nullptr;
  check(TRITONSERVER_MessageNewFromSerializedJson(&made, text.data(), text.size()));
  const Message message(made);
  check(TRITONBACKEND_ModelSetConfig(model, 1, message.get()));
}

std::string name_of(TRITONBACKEND_Model* model) {
  const char* name = nullptr;
  check(TRITONBACKEND_ModelName(model, &name));
  return name;
}

uint64_t version_of(TRITONBACKEND_Model* model) {
  uint64_t version = 0;
  check(TRITONBACKEND_ModelVersion(model, &version));
  return version;
}

/** The *.chiasm in the version's folder: the only one, or that which `default_model_filename` names. */
std::string bundle_path(TRITONBACKEND_Model* model, const json& config) {
  TRITONBACKEND_ArtifactType type{};
  const char* repository = nullptr;
  check(TRITONBACKEND_ModelRepository(model, &type, &repository));
  if (type != TRITONBACKEND_ARTIFACT_FILESYSTEM) refuse("the model repository is not a folder of files");
  const fs::path folder = fs::path(repository) / std::to_string(version_of(model));
  if (const std::string named = config.value("default_model_filename", ""); !named.empty())
    return (folder / named).string();
  std::vector<fs::path> found;
  std::error_code error;
  for (auto entry = fs::directory_iterator(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (entry->path().extension() == ".chiasm") found.push_back(entry->path());
  }
  if (error) throw Failure(TRITONSERVER_ERROR_NOT_FOUND, folder.string() + ": " + error.message());
  if (found.empty())
    throw Failure(TRITONSERVER_ERROR_NOT_FOUND,
                  folder.string() + ": expected a bundle, a folder NAME.chiasm, and found none");
  if (found.size() > 1)
    refuse(folder.string() + ": expected one bundle, found " + std::to_string(found.size()) +
           "; keep one, or name it by default_model_filename");
  return found[0].string();
}

Metric make_metric(TRITONSERVER_MetricFamily* family, TRITONBACKEND_Model* model, const Bundle& bundle,
                   const Method& method) {
  if (family == nullptr) return nullptr;
  const std::pair<const char*, std::string> labels[] = {{"model", name_of(model)},
                                                        {"version", std::to_string(version_of(model))},
                                                        {"bundle", bundle.info().name},
                                                        {"artifact", method.artifact()},
                                                        {"backend", method.backend()}};
  std::vector<std::unique_ptr<TRITONSERVER_Parameter, DeleteParameter>> owned;
  std::vector<const TRITONSERVER_Parameter*> given;
  for (const auto& [key, value] : labels) {
    owned.emplace_back(TRITONSERVER_ParameterNew(key, TRITONSERVER_PARAMETER_STRING, value.c_str()));
    given.push_back(owned.back().get());
  }
  TRITONSERVER_Metric* made = nullptr;
  check(TRITONSERVER_MetricNew(&made, family, given.data(), given.size()));
  Metric metric(made);
  check(TRITONSERVER_MetricSet(metric.get(), 1));
  return metric;
}

}  // namespace

void DeleteMetric::operator()(TRITONSERVER_Metric* metric) const noexcept {
  log_failure(TRITONSERVER_MetricDelete(metric));
}

void DeleteFamily::operator()(TRITONSERVER_MetricFamily* family) const noexcept {
  log_failure(TRITONSERVER_MetricFamilyDelete(family));
}

MetricFamily make_metric_family() {
  TRITONSERVER_MetricFamily* family = nullptr;
  TRITONSERVER_Error* const error =
      TRITONSERVER_MetricFamilyNew(&family, TRITONSERVER_METRIC_KIND_GAUGE, "chiasm_model_info",
                                   "1 for each loaded model: its bundle and the artifact that runs");
  if (error != nullptr) TRITONSERVER_ErrorDelete(error);
  return MetricFamily(family);
}

Model::Model(TRITONBACKEND_Model* model, TRITONSERVER_MetricFamily* family)
    : bundle_(nullptr), method_(nullptr) {
  const json config = read_config(model);
  parameters_ = read_parameters(config);
  bundle_ = Bundle::open(bundle_path(model, config));
  method_ = bundle_.method(parameters_.method, parameters_.load);
  signature_ = read_signature(method_.info(), bundle_.info().manifest);
  const json completed = complete(config, signature_);
  bool may_complete = false;
  check(TRITONBACKEND_ModelAutoCompleteConfig(model, &may_complete));
  if (may_complete) {
    write_config(model, completed);
  } else if (config.value("input", json::array()).empty() || config.value("output", json::array()).empty()) {
    refuse("the configuration names no input or no output, and this server lets nobody complete it");
  }
  metric_ = make_metric(family, model, bundle_, method_);
  const BundleInfo info = bundle_.info();
  check(TRITONSERVER_LogMessage(
      TRITONSERVER_LOG_INFO, __FILE__, __LINE__,
      ("chiasm: model '" + name_of(model) + "' runs " + info.name + " " + info.version + ", " +
       method_.artifact() + " on the backend " + method_.backend())
          .c_str()));
}

}  // namespace chiasm::triton
