/** Waiting for another thread that is at work. */
#pragma once

#if defined(__x86_64__)
#include "spin_x86.h"
#endif

namespace chiasm {

/** Tells the core that this thread spins; 10 to 60 ns. */
inline void relax() {
#if defined(__x86_64__)
  pause_core();
#endif
}

}  // namespace chiasm
