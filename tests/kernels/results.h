// What the kernels give for one instruction set, held to what they gave for another: with
// $CHIASM_RECORD_RESULTS a test writes all results into a file of this folder, with $CHIASM_EXPECTED_RESULTS
// it compares them with that file. Without either it does nothing.
#pragma once

#include <fstream>

#include "artifact/aoti/tensor.h"

namespace kernel_calls {

class Results {
 public:
  /** Of the test that is running. Throws std::runtime_error where its file cannot be opened. */
  Results();

  /** kExact: numbers are equal, and NaN is where NaN was; kRounded: floating-point numbers may differ by a
   *  few units in the last place of the largest; kAny: sizes alone are compared. */
  enum Comparison { kExact, kRounded, kAny };

  /** The next result. */
  void see(const AtenTensorOpaque& result, Comparison comparison);

 private:
  std::ofstream record_;
  std::ifstream expected_;
  int64_t seen_ = 0;
};

}  // namespace kernel_calls
