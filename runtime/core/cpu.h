/** What the CPU can run. */
#pragma once

#include "core/manifest.h"

namespace chiasm::core {

/** Whether this CPU has every feature of the level (and the system saves its registers). */
bool cpu_supports(Isa isa);

/** Whether a CPU whose highest level is `cpu` runs code for `code`. */
bool has(Isa cpu, Isa code);

}  // namespace chiasm::core
