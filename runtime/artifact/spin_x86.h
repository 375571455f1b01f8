/** x86-64's instruction for a thread that spins. */
#pragma once

namespace chiasm {

inline void pause_core() { __builtin_ia32_pause(); }

}  // namespace chiasm
