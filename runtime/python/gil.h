/** Releases Python's global lock around work in C++. */
#pragma once

#include <cxxabi.h>
#include <pybind11/pybind11.h>
#include <unistd.h>

namespace chiasm::python {

/** Python's lock is released during this object's life. If the interpreter ends meanwhile, the destructor
 *  waits for the end of the process, as Python 3.14 does itself. Older versions end the thread by an
 *  exception, and an exception that leaves a destructor ends the process. */
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
