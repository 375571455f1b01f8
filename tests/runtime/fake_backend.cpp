/** A backend without an engine, for tests of the core. Its artifacts are text:
 *
 *      scale K     every output element j is K times element j (modulo the count) of the first input
 *      broken      cannot be loaded
 *      failing     loads, and fails in every run
 *
 *  In format onnx they are the doc_string of a model.
 *
 *  FAKE_NAME is its name, FAKE_FORMATS the formats that it loads, FAKE_PRIORITY its place in `auto`.
 *  FAKE_ENGINE_MISSING makes a backend whose engine is missing; FAKE_ABI, FAKE_PROBE_FAILS and FAKE_NEEDS
 *  make backends that must be rejected. A member of the table that the environment variable FAKE_LACKS names
 *  is NULL. A backend has CUDA if fake_cuda.cpp is the driver.
 */
#include <dlfcn.h>

#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>

#include "backends/onnx/onnx_file.h"
#include "base/error.h"
#include "chiasm/backend.h"

#ifndef FAKE_FORMATS
#define FAKE_FORMATS \
  {"aotinductor", 1}, { "torchscript", 1 }
#endif
#ifndef FAKE_PRIORITY
#define FAKE_PRIORITY 1
#endif
#ifndef FAKE_ABI
#define FAKE_ABI CHIASM_BACKEND_ABI
#endif

namespace {

struct Model {
  double scale = 1;
  bool failing = false;
  int32_t inputs = 0, outputs = 0;
};

int32_t report(chiasm_error_text* error, int32_t code, const char* text) {
  std::strncpy(error->text, text, sizeof error->text - 1);
  return code;
}

int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
#if defined(FAKE_PROBE_FAILS)
  (void)info;
  return report(error, CHIASM_UNAVAILABLE, "the fake engine is too old");
#elif defined(FAKE_ENGINE_MISSING)
  (void)info;
  return dlopen("libfake_engine.so", RTLD_NOW) == nullptr ? report(error, CHIASM_UNAVAILABLE, dlerror())
                                                          : CHIASM_OK;
#else
  (void)error;
  info->engine_version = "fake 1.0";
  void* const driver = dlopen("libcuda.so.1", RTLD_NOW | RTLD_NOLOAD);
  info->has_cuda = driver != nullptr && dlsym(driver, "fake_cuda_fail") != nullptr ? 1 : 0;
  return CHIASM_OK;
#endif
}

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  // An ONNX model begins with the tag and the size of its doc_string, which contains the words.
  const size_t start = std::strstr(request->format, "onnx") != nullptr && request->size > 2 ? 2 : 0;
  if (start != 0) {
    try {
      chiasm::onnx::check_onnx(static_cast<const unsigned char*>(request->data), request->size, "the model");
    } catch (const chiasm::base::Error& refused) {
      return report(error, refused.code(), refused.what());
    }
  }
  std::istringstream words(
      std::string(static_cast<const char*>(request->data) + start, request->size - start));
  std::string word;
  words >> word;
  if (word == "broken") return report(error, CHIASM_CORRUPT, "the fake engine cannot read this");
  auto* const loaded = new Model;
  loaded->failing = word == "failing";
  if (word == "scale") words >> loaded->scale;
  loaded->inputs = request->input_count;
  loaded->outputs = request->output_count;
  *model = loaded;
  return CHIASM_OK;
}

template <class T>
void scale(double factor, const chiasm_tensor& from, size_t from_count, const chiasm_tensor& to,
           size_t to_count) {
  const T* const source = static_cast<const T*>(from.data);
  T* const target = static_cast<T*>(to.data);
  for (size_t i = 0; i < to_count; ++i)
    target[i] = static_cast<T>(factor * static_cast<double>(source[i % from_count]));
}

size_t count_of(const chiasm_tensor& tensor) {
  size_t count = 1;
  for (int32_t i = 0; i < tensor.ndim; ++i) count *= static_cast<size_t>(tensor.shape[i]);
  return count;
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options*,
            chiasm_error_text* error) {
  const auto* const self = static_cast<const Model*>(model);
  if (self->failing) return report(error, CHIASM_INTERNAL, "the fake engine fails in every run");
  for (int32_t i = 0; i < self->inputs; ++i) {
    if (inputs[i].strides != nullptr) return report(error, CHIASM_INTERNAL, "the core let strides through");
  }
  for (int32_t i = 0; i < self->outputs; ++i) {
    if (outputs[i].dtype == CHIASM_FLOAT64 && inputs[0].dtype == CHIASM_FLOAT64) {
      scale<double>(self->scale, inputs[0], count_of(inputs[0]), outputs[i], count_of(outputs[i]));
    } else if (outputs[i].dtype == CHIASM_FLOAT32 && inputs[0].dtype == CHIASM_FLOAT32) {
      scale<float>(self->scale, inputs[0], count_of(inputs[0]), outputs[i], count_of(outputs[i]));
    } else if (outputs[i].dtype == CHIASM_UINT8 && inputs[0].dtype == CHIASM_UINT8) {
      scale<unsigned char>(self->scale, inputs[0], count_of(inputs[0]), outputs[i], count_of(outputs[i]));
    } else {
      return report(error, CHIASM_INTERNAL, "the fake engine does not know these dtypes");
    }
  }
  return CHIASM_OK;
}

void unload(void* model) { delete static_cast<Model*>(model); }

const chiasm_backend_format kFormats[] = {FAKE_FORMATS, {nullptr, 0}};
const chiasm_backend_option kOptions[] = {{"fused", "0 or 1", "as the onnx backend has it"},
                                          {nullptr, nullptr, nullptr}};

int32_t rank(const chiasm_backend_load* request) {
  if (std::strcmp(request->format, "fused_onnx") != 0) return 0;
  for (const char* const* option = request->options; *option != nullptr; ++option) {
    if (std::strcmp(*option, "fused=0") == 0) return -1;
  }
  return 1;
}

const chiasm_backend kBackend = {sizeof(chiasm_backend),
                                 FAKE_ABI,
                                 FAKE_NAME,
                                 FAKE_PRIORITY,
                                 kFormats,
                                 1u << CHIASM_CPU | 1u << CHIASM_CUDA,
                                 kOptions,
                                 probe,
                                 rank,
                                 load,
                                 run,
                                 unload};

const chiasm_backend* table() {
  const char* const lacks = std::getenv("FAKE_LACKS");
  if (lacks == nullptr) return &kBackend;
  static const chiasm_backend_option without_values[] = {{"fused", nullptr, ""}, {nullptr, nullptr, nullptr}};
  static chiasm_backend incomplete;
  incomplete = kBackend;
  const std::string member = lacks;
  if (member == "formats") incomplete.formats = nullptr;
  if (member == "probe") incomplete.probe = nullptr;
  if (member == "load") incomplete.load = nullptr;
  if (member == "run") incomplete.run = nullptr;
  if (member == "unload") incomplete.unload = nullptr;
  if (member == "values of an option") incomplete.options = without_values;
  return &incomplete;
}

}  // namespace

#ifdef FAKE_NEEDS
extern "C" int fake_engine_function();
#endif

extern "C" __attribute__((visibility("default"))) const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
#ifdef FAKE_NEEDS
  if (fake_engine_function() != 0) return nullptr;
#endif
  return abi == FAKE_ABI ? table() : nullptr;
}
