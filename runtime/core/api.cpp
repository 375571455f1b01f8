// The functions behind the table of the C interface: each checks its arguments, calls the core, and turns
// exceptions into statuses.
#include "core/api.h"

#include <pthread.h>

#include <algorithm>
#include <map>
#include <mutex>

#include "base/fork.h"
#include "core/bundle.h"
#include "core/method.h"
#include "core/registry.h"
#include "core/run_each.h"
#include "core/self_test.h"
#include "core/status.h"
#include "core/struct_size.h"
#include "core/threads.h"
#include "core/trust.h"

struct chiasm_bundle {
  std::shared_ptr<const chiasm::core::Bundle> bundle;
};

struct chiasm_method {
  std::shared_ptr<const chiasm::core::Method> method;
};

/** One output set: what `chiasm_outputs*` points to is an Outputs. */
struct chiasm_outputs;

namespace chiasm::core {
namespace {

constexpr size_t kMaxKeys = 1024;

void need(const void* pointer, const char* name) {
  if (pointer == nullptr) fail(CHIASM_INVALID_ARGUMENT, std::string(name) + " is NULL");
}

const char* library_version() { return CHIASM_LIBRARY_VERSION; }

size_t backend_count() {
  size_t count = 0;
  status_free(guarded([&] { count = Registry::instance().all().size(); }));
  return count;
}

chiasm_status* backend_info(size_t index, chiasm_backend_info* info) {
  return guarded([&] {
    need(info, "info");
    const auto& all = Registry::instance().all();
    if (index >= all.size()) {
      fail(CHIASM_INVALID_ARGUMENT,
           "there is no backend " + std::to_string(index) + ", only " + std::to_string(all.size()));
    }
    check_struct_size(info->struct_size, CHIASM_SIZE_THROUGH(chiasm_backend_info, problem), "backend info",
                      "set it to sizeof(chiasm_backend_info)");
    const Backend& backend = *all[index];
    const Backend::Engine& engine = backend.engine();
    info->name = backend.name().c_str();
    info->available = engine.problem.empty() ? 1 : 0;
    info->has_cuda = engine.has_cuda ? 1 : 0;
    info->engine_version = engine.version.c_str();
    info->problem = engine.problem.c_str();
  });
}

chiasm_status* set_threads(int32_t count) {
  return guarded([&] { set_num_threads(count); });
}

chiasm_status* set_trust_policy(int32_t policy, const char* const* keys, size_t key_count) {
  return guarded([&] {
    if (key_count > kMaxKeys) {
      fail(CHIASM_INVALID_ARGUMENT,
           std::to_string(key_count) + " keys, expected at most " + std::to_string(kMaxKeys));
    }
    if (key_count > 0) need(keys, "keys");
    std::vector<std::string> texts;
    for (size_t i = 0; i < key_count; ++i) {
      need(keys[i], "a key");
      texts.emplace_back(keys[i]);
    }
    set_trust(policy, texts);
  });
}

/** Lists of keys' texts, in memory that is never freed. */
struct KeyTexts {
  using Lists = std::map<std::vector<std::string>, std::vector<const char*>>;
  std::mutex mutex;
  Lists* lists = new Lists;

  static KeyTexts& instance() {
    static KeyTexts* const texts = [] {
      ::pthread_atfork(nullptr, nullptr, [] {
        KeyTexts& in_child = instance();
        if (!free_in_child(in_child.mutex)) in_child.lists = new Lists;  // the old ones may be half changed
      });
      return new KeyTexts;
    }();
    return *texts;
  }
};

/** The texts of these keys. */
const std::vector<const char*>& interned(const std::vector<PublicKey>& keys) {
  KeyTexts& known = KeyTexts::instance();
  std::vector<std::string> texts;
  for (const PublicKey& key : keys) texts.push_back(text_of(key));
  std::vector<const char*> pointers;  // made first: a list is entered whole, or not at all without memory
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  const std::lock_guard<std::mutex> lock(known.mutex);
  // the texts stay where they are when their vector is moved
  return known.lists->try_emplace(std::move(texts), std::move(pointers)).first->second;
}

chiasm_status* get_trust_policy(int32_t* policy, const char* const** keys, size_t* key_count) {
  return guarded([&] {
    need(policy, "policy");
    const Trust trust = get_trust();
    *policy = trust.policy;
    if (keys != nullptr) *keys = interned(trust.keys).data();
    if (key_count != nullptr) *key_count = trust.keys.size();
  });
}

chiasm_status* bundle_open(const char* path, chiasm_bundle** bundle) {
  return guarded([&] {
    need(bundle, "bundle");
    *bundle = nullptr;
    need(path, "path");
    *bundle = new chiasm_bundle{std::make_shared<const Bundle>(path, get_trust())};
  });
}

void bundle_close(chiasm_bundle* bundle) { delete bundle; }

const chiasm_bundle_info* bundle_get_info(const chiasm_bundle* bundle) {
  return bundle == nullptr ? nullptr : &bundle->bundle->info();
}

chiasm_status* bundle_self_test(chiasm_bundle* bundle, const chiasm_load_options* options,
                                chiasm_self_test_callback callback, void* user, int32_t* failed) {
  return guarded([&] {
    need(bundle, "bundle");
    const int32_t count =
        self_test(bundle->bundle, read_load_options(options), Registry::instance(), callback, user);
    if (failed != nullptr) *failed = count;
  });
}

chiasm_status* method_load(chiasm_bundle* bundle, const char* name, const chiasm_load_options* options,
                           chiasm_method** method) {
  return guarded([&] {
    need(method, "method");
    *method = nullptr;
    need(bundle, "bundle");
    need(name, "name");
    *method = new chiasm_method{Method::load(bundle->bundle, name, read_load_options(options))};
  });
}

void method_close(chiasm_method* method) { delete method; }

const chiasm_method_info* method_get_info(const chiasm_method* method) {
  return method == nullptr ? nullptr : &method->method->info();
}

const char* method_backend(const chiasm_method* method) {
  return method == nullptr ? "" : method->method->backend();
}

const char* method_artifact(const chiasm_method* method) {
  return method == nullptr ? "" : method->method->artifact();
}

chiasm_status* method_output_shape(const chiasm_method* method, const chiasm_tensor* inputs,
                                   size_t input_count, size_t index, int64_t* shape, int32_t* ndim,
                                   int32_t* dtype) {
  return guarded([&] {
    need(method, "method");
    need(shape, "shape");
    need(ndim, "ndim");
    need(dtype, "dtype");
    const Signature& signature = method->method->signature();
    if (index >= signature.output_count()) {
      fail(CHIASM_INVALID_ARGUMENT, "there is no output " + std::to_string(index) + ", only " +
                                        std::to_string(signature.output_count()));
    }
    Call call;
    signature.check_inputs(inputs, input_count, call);
    const chiasm_tensor output = call.seen_output(index);
    *ndim = output.ndim;
    *dtype = output.dtype;
    std::copy_n(output.shape, output.ndim, shape);
  });
}

chiasm_status* method_run(chiasm_method* method, const chiasm_tensor* inputs, size_t input_count,
                          const chiasm_run_options* options, chiasm_outputs** outputs) {
  return guarded([&] {
    need(outputs, "outputs");
    *outputs = nullptr;
    need(method, "method");
    *outputs = reinterpret_cast<chiasm_outputs*>(method->method->run(inputs, input_count, options).release());
  });
}

chiasm_status* method_run_into(chiasm_method* method, const chiasm_tensor* inputs, size_t input_count,
                               const chiasm_tensor* outputs, size_t output_count,
                               const chiasm_run_options* options) {
  return guarded([&] {
    need(method, "method");
    method->method->run_into(inputs, input_count, outputs, output_count, options);
  });
}

chiasm_status* method_run_each(chiasm_method* method, size_t runs, const chiasm_tensor* inputs,
                               size_t input_count, const chiasm_tensor* outputs, size_t output_count,
                               const chiasm_run_options* options) {
  return guarded([&] {
    need(method, "method");
    run_each(*method->method, runs, inputs, input_count, outputs, output_count, options);
  });
}

size_t outputs_count(const chiasm_outputs* outputs) {
  return outputs == nullptr ? 0 : reinterpret_cast<const Outputs*>(outputs)->count();
}

const chiasm_tensor* outputs_get(const chiasm_outputs* outputs, size_t index) {
  return outputs == nullptr ? nullptr : reinterpret_cast<const Outputs*>(outputs)->get(index);
}

void outputs_free(chiasm_outputs* outputs) { delete reinterpret_cast<Outputs*>(outputs); }

constexpr chiasm_api kApi = {
    sizeof(chiasm_api), CHIASM_API_VERSION, status_code,     status_message,   status_free,
    library_version,    backend_count,      backend_info,    set_threads,      get_num_threads,
    bundle_open,        bundle_close,       bundle_get_info, bundle_self_test, method_load,
    method_close,       method_get_info,    method_backend,  method_artifact,  method_output_shape,
    method_run,         method_run_into,    outputs_count,   outputs_get,      outputs_free,
    set_trust_policy,   get_trust_policy,   method_run_each,
};

}  // namespace

const chiasm_api* api_table(uint32_t version) noexcept {
  return version >= 1 && version <= CHIASM_API_VERSION ? &kApi : nullptr;
}

}  // namespace chiasm::core
