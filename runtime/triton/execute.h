/** Requests, from Triton's buffers into each response's own. */
#pragma once

#include <triton/core/tritonbackend.h>

#include <cstdint>

#include "triton/crew.h"
#include "triton/model.h"

namespace chiasm::triton {

/** Answers every request of a batch by itself, reports its statistics, and releases it. What it throws, it throws
 *  before the first answer, so that the requests are still Triton's. */
void execute(const Model& model, Crew& crew, TRITONBACKEND_ModelInstance* instance,
             TRITONBACKEND_Request** requests, uint32_t count);

}  // namespace chiasm::triton
