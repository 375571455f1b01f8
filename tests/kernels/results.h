// Compares the kernels' results for one instruction set with those for another. With $CHIASM_RECORD_RESULTS,
// a test writes all results to a file in this folder; with $CHIASM_EXPECTED_RESULTS, it compares them with
// that file. Without either, it does nothing.
#pragma once

#include <fstream>

#include "artifact/aoti/tensor.h"

namespace kernel_calls {

class Results {
 public:
  /** The results of the running test. Throws std::runtime_error if its file cannot be opened. */
  Results();

  /** kExact: numbers are equal, and NaN is at the same places; kRounded: floating-point numbers may differ by
   *  a few units in the last place of the largest; kAny: only sizes are compared. */
  enum Comparison { kExact, kRounded, kAny };

  /** Records or compares the next result. */
  void see(const AtenTensorOpaque& result, Comparison comparison);

 private:
  std::ofstream record_;
  std::ifstream expected_;
  int64_t seen_ = 0;
};

}  // namespace kernel_calls
