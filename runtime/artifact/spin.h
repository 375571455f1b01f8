/** Waiting for another thread that is at work. */
#pragma once

namespace chiasm {

/** Tells the core that this thread spins; 10 to 60 ns. */
inline void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace chiasm
