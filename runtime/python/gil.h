#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace chiasm::python {

/** Releases Python's lock while it lives. If the interpreter ends meanwhile, the thread waits for the end of the
 *  process, as it does from Python 3.14 on: older versions end it by an exception, which would end the process
 *  in a destructor. */
class WithoutGil final {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    try {
      PyEval_RestoreThread(state_);
    } catch (const abi::__forced_unwind&) {
      for (;;) pause();
    }
  }

 private:
  PyThreadState* state_;
};

}  // namespace chiasm::python
