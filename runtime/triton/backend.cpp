/** The functions that Triton calls. Each is a few lines, because no exception may leave it. */
#include <triton/core/tritonbackend.h>

#include <memory>
#include <string>

#include "triton/crew.h"
#include "triton/errors.h"
#include "triton/execute.h"
#include "triton/model.h"

namespace chiasm::triton {
namespace {

/** One per server. */
struct Backend {
  Crew crew{static_cast<size_t>(get_num_threads() - 1)};
  MetricFamily family = make_metric_family();
};

Backend& backend_of(TRITONBACKEND_Model* model) {
  TRITONBACKEND_Backend* backend = nullptr;
  void* state = nullptr;
  check(TRITONBACKEND_ModelBackend(model, &backend));
  check(TRITONBACKEND_BackendState(backend, &state));
  return *static_cast<Backend*>(state);
}

Model* model_of(TRITONBACKEND_Model* model) {
  void* state = nullptr;
  check(TRITONBACKEND_ModelState(model, &state));
  return static_cast<Model*>(state);
}

}  // namespace
}  // namespace chiasm::triton

extern "C" {

using namespace chiasm::triton;

TRITONSERVER_Error* TRITONBACKEND_Initialize(TRITONBACKEND_Backend* backend) {
  return guarded([&] {
    uint32_t major = 0, minor = 0;
    check(TRITONBACKEND_ApiVersion(&major, &minor));
    if (major != TRITONBACKEND_API_VERSION_MAJOR || minor < TRITONBACKEND_API_VERSION_MINOR)
      throw Failure(TRITONSERVER_ERROR_UNSUPPORTED,
                    "this server's backend interface is " + std::to_string(major) + "." +
                        std::to_string(minor) + ", chiasm's backend needs " +
                        std::to_string(TRITONBACKEND_API_VERSION_MAJOR) + "." +
                        std::to_string(TRITONBACKEND_API_VERSION_MINOR) + " or a later one");
    auto state = std::make_unique<Backend>();
    check(TRITONBACKEND_BackendSetState(backend, state.get()));
    static_cast<void>(state.release());
  });
}

TRITONSERVER_Error* TRITONBACKEND_Finalize(TRITONBACKEND_Backend* backend) {
  return guarded([&] {
    void* state = nullptr;
    check(TRITONBACKEND_BackendState(backend, &state));
    delete static_cast<Backend*>(state);
  });
}

/** One instance per core, if a configuration does not set instances: each runs a request on one thread. */
TRITONSERVER_Error* TRITONBACKEND_GetBackendAttribute(TRITONBACKEND_Backend* /*backend*/,
                                                      TRITONBACKEND_BackendAttribute* attributes) {
  return guarded([&] {
    const auto cores = static_cast<uint64_t>(chiasm::get_num_threads());
    check(TRITONBACKEND_BackendAttributeAddPreferredInstanceGroup(
        attributes, TRITONSERVER_INSTANCEGROUPKIND_CPU, cores, nullptr, 0));
  });
}

TRITONSERVER_Error* TRITONBACKEND_ModelInitialize(TRITONBACKEND_Model* model) {
  return guarded([&] {
    auto state = std::make_unique<Model>(model, backend_of(model).family.get());
    check(TRITONBACKEND_ModelSetState(model, state.get()));
    static_cast<void>(state.release());
  });
}

TRITONSERVER_Error* TRITONBACKEND_ModelFinalize(TRITONBACKEND_Model* model) {
  return guarded([&] { delete model_of(model); });
}

TRITONSERVER_Error* TRITONBACKEND_ModelInstanceInitialize(TRITONBACKEND_ModelInstance* instance) {
  return guarded([&] {
    TRITONSERVER_InstanceGroupKind kind{};
    check(TRITONBACKEND_ModelInstanceKind(instance, &kind));
    if (kind != TRITONSERVER_INSTANCEGROUPKIND_CPU)
      throw Failure(
          TRITONSERVER_ERROR_UNSUPPORTED,
          std::string("instance_group: this backend runs on the CPU: expected KIND_CPU, got KIND_") +
              TRITONSERVER_InstanceGroupKindString(kind));
  });
}

TRITONSERVER_Error* TRITONBACKEND_ModelInstanceExecute(TRITONBACKEND_ModelInstance* instance,
                                                       TRITONBACKEND_Request** requests,
                                                       const uint32_t request_count) {
  return guarded([&] {
    TRITONBACKEND_Model* model = nullptr;
    check(TRITONBACKEND_ModelInstanceModel(instance, &model));
    execute(*model_of(model), backend_of(model).crew, instance, requests, request_count);
  });
}

}  // extern "C"
