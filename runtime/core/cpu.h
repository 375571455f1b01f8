/** What the CPU can run. */
#pragma once

#include <vector>

#include "core/manifest.h"

namespace chiasm::core {

/** Whether this CPU has every feature of the level (and the system saves its registers). */
bool cpu_supports(Isa isa);

/** The instruction sets that this CPU has, the highest last. */
std::vector<Isa> supported_isas();

/** Whether a CPU whose highest level is `cpu` runs code for `code`. */
bool has(Isa cpu, Isa code);

}  // namespace chiasm::core
