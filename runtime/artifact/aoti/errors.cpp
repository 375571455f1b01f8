// Values of inputs that an op does not allow, found by its compiled loops (chiasm/checked.h) in any of the
// run's threads.
#include <cstdio>

#include "tensor.h"

namespace chiasm {
namespace artifact {

void refuse(const char* text) {
  Run* run = run_of_this_thread();
  if (!run || run->refused.exchange(true, std::memory_order_acq_rel)) return;
  std::snprintf(run->refusal, sizeof run->refusal, "%s", text);
}

}  // namespace artifact

[[gnu::cold, gnu::noinline]] void note_index(int64_t index, int64_t size, const char* reader) {
  char text[256];
  std::snprintf(text, sizeof text, "index %lld is out of range for an axis of size %lld (%s)",
                static_cast<long long>(index), static_cast<long long>(size), reader);
  artifact::refuse(text);
}

[[gnu::cold, gnu::noinline]] void note_division() { artifact::refuse("an integer was divided by zero"); }

}  // namespace chiasm
