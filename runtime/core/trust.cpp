// The trust policy: set by the program, else read from the environment, and fixed when it is first used.
#include "core/trust.h"

#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string_view>

#include "base/fork.h"
#include "core/file.h"
#include "core/registry.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr const char* kPolicyNames[] = {"any", "signed", "data_only"};

/** A trust that was set, and those set before it, which readers may still have. */
struct Set {
  Trust trust;
  std::unique_ptr<const Set> before;
};

/** A fork may come at any time. So a new trust is one store, and files of keys are read without the lock. */
struct State {
  std::mutex mutex;  // of whoever sets
  std::atomic<const Set*> last{nullptr};
  std::atomic<bool> used{false};

  void set(Trust trust) { last.store(new Set{std::move(trust), std::unique_ptr<const Set>(last.load())}); }
};

State& state() {
  static State* const instance = [] {
    ::pthread_atfork(nullptr, nullptr, [] { free_in_child(state().mutex); });
    return new State;
  }();
  return *instance;
}

PublicKey read_key(const std::string& text) {
  constexpr size_t kKeySize = 56;
  if (text.size() == kKeySize && text.compare(0, 2, "RW") == 0)
    return read_public_key(text, "the trusted key '" + text + "'");
  try {
    const Bytes file = read_file(text, kMaxSignatureSize);
    return read_public_key({reinterpret_cast<const char*>(file.data()), file.size()}, text);
  } catch (const Error& error) {
    fail(error.code(), std::string("the trusted key ") + error.what());
  }
}

Trust make_trust(int32_t policy, const std::vector<std::string>& keys) {
  Trust trust;
  trust.policy = policy;
  for (const std::string& key : keys) trust.keys.push_back(read_key(key));
  if (policy == CHIASM_TRUST_SIGNED && keys.empty()) {
    fail(CHIASM_INVALID_ARGUMENT,
         "the trust policy 'signed' needs a trusted key: set CHIASM_TRUSTED_KEYS, or give one to set_trust");
  }
  return trust;
}

Trust from_environment() {
  const char* const name = std::getenv("CHIASM_TRUST_POLICY");
  const std::vector<std::string> keys = split_path(std::getenv("CHIASM_TRUSTED_KEYS"));
  const bool is_set = name != nullptr && name[0] != '\0';
  if (!is_set && !keys.empty()) {
    fail(CHIASM_INVALID_ARGUMENT,
         "CHIASM_TRUSTED_KEYS is set and CHIASM_TRUST_POLICY is not: set it to signed, or to any");
  }
  int32_t policy = is_set ? -1 : CHIASM_TRUST_ANY;
  for (int32_t i = 0; policy < 0 && i < 3; ++i) policy = std::string_view(name) == kPolicyNames[i] ? i : -1;
  if (policy < 0) {
    fail(CHIASM_INVALID_ARGUMENT,
         std::string("CHIASM_TRUST_POLICY is '") + name + "', expected any, signed or data_only");
  }
  return make_trust(policy, keys);
}

}  // namespace

void set_trust(int32_t policy, const std::vector<std::string>& keys) {
  if (policy < CHIASM_TRUST_ANY || policy > CHIASM_TRUST_DATA_ONLY) {
    fail(CHIASM_INVALID_ARGUMENT,
         "unknown trust policy " + std::to_string(policy) + ", expected a chiasm_trust_policy");
  }
  Trust trust = make_trust(policy, keys);
  State& now = state();
  const std::lock_guard<std::mutex> lock(now.mutex);
  if (now.used)
    fail(CHIASM_FAILED_PRECONDITION, "the trust policy cannot change after the first method was loaded");
  now.set(std::move(trust));
}

Trust get_trust() {
  const Set* const last = state().last.load();
  return last != nullptr ? last->trust : from_environment();
}

const Trust& use_trust() {
  State& now = state();
  if (!now.used) {
    Trust trust = get_trust();
    const std::lock_guard<std::mutex> lock(now.mutex);
    if (now.last.load() == nullptr) now.set(std::move(trust));
    now.used = true;
  }
  return now.last.load()->trust;
}

}  // namespace chiasm::core
