/** A loaded method: checks, then the backend. */
#pragma once

#include <memory>
#include <vector>

#include "base/pool.h"
#include "core/bundle.h"
#include "core/load_call.h"
#include "core/registry.h"
#include "core/select.h"
#include "core/signature.h"

namespace chiasm::core {

/** Output tensors that own their memory. */
class Outputs final {
 public:
  /** Memory for the outputs of `call`; the pointers are entered there. */
  Outputs(Call& call, const std::vector<TensorSpec>& outputs);
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  size_t count() const { return slots_.size(); }
  const chiasm_tensor* get(size_t i) const { return i < slots_.size() ? &slots_[i].tensor : nullptr; }

 private:
  struct Slot {
    chiasm_tensor tensor;
    int64_t shape[CHIASM_MAX_DIMS];
    PooledMemory memory;
  };
  std::vector<Slot> slots_;
};

/** Throws Error (INVALID_ARGUMENT) for options whose size is wrong. NULL is allowed. */
void check_run_options(const chiasm_run_options* options);

/** Immutable once loaded; run may be called from many threads at once. */
class Method final {
 public:
  /** Load the artifact that suits the request best. Throws Error. */
  static std::shared_ptr<Method> load(std::shared_ptr<const Bundle> bundle, const char* name,
                                      const LoadRequest& asked);

  /** Load this artifact with this backend, which is available. */
  Method(std::shared_ptr<const Bundle> bundle, const MethodSpec& spec, const Artifact& artifact,
         const Backend& backend, int32_t dtype, const LoadRequest& request);
  Method(const Method&) = delete;
  Method& operator=(const Method&) = delete;
  ~Method();

  const chiasm_method_info& info() const { return info_.get(); }
  const char* backend() const { return backend_.name().c_str(); }
  const char* artifact() const { return artifact_.file.c_str(); }
  const Signature& signature() const { return signature_; }

  std::unique_ptr<Outputs> run(const chiasm_tensor* inputs, size_t count,
                               const chiasm_run_options* options) const;
  void run_into(const chiasm_tensor* inputs, size_t input_count, const chiasm_tensor* outputs,
                size_t output_count, const chiasm_run_options* options) const;
  /** The checks of run_into: fills `call`. */
  void check(const chiasm_tensor* inputs, size_t input_count, const chiasm_tensor* outputs,
             size_t output_count, const chiasm_run_options* options, Call& call) const;
  /** How many concurrent runs the process's number of threads allows. */
  size_t runs_at_once() const;
  /** Run a call that was checked and has all its data. */
  void execute(const Call& call, const chiasm_run_options* options) const;

 private:
  void load_model(const LoadCall& call);
  void warm_up() const;

  std::shared_ptr<const Bundle> bundle_;
  const MethodSpec& spec_;
  const Artifact& artifact_;
  const Backend& backend_;
  int32_t device_type_, device_index_, num_threads_;
  Signature signature_;
  MethodInfo info_;
  void* model_ = nullptr;
};

}  // namespace chiasm::core
