/** Runs requests, from Triton's buffers into the buffers of their responses. */
#pragma once

#include <triton/core/tritonbackend.h>

#include <cstdint>

#include "triton/crew.h"
#include "triton/model.h"

namespace chiasm::triton {

/** Answers every request of a batch by itself, reports its statistics, and releases it. Throws only before
 *  the first answer, so that Triton still owns the requests. */
void execute(const Model& model, Crew& crew, TRITONBACKEND_ModelInstance* instance,
             TRITONBACKEND_Request** requests, uint32_t count);

}  // namespace chiasm::triton
