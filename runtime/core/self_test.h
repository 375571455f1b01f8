/** Replays a bundle's golden vectors on this machine. */
#pragma once

#include <memory>

#include "core/bundle.h"
#include "core/select.h"

namespace chiasm::core {

/** One row per golden case and artifact; returns how many failed. `request` limits backend, dtype and device.
 *  Throws Error if the golden file itself cannot be used. */
int32_t self_test(const std::shared_ptr<const Bundle>& bundle, const LoadRequest& request, Registry& registry,
                  chiasm_self_test_callback callback, void* user);

}  // namespace chiasm::core
