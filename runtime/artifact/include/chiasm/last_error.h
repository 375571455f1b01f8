// The text of a thread's last error, in AOTInductor's interface, in place of its std::string: a thread_local with a destructor
// pins the library in the process for as long as the thread lives.
#pragma once

#include <cstdio>

namespace chiasm {

class LastError {
 public:
  LastError& operator=(const char* text) {
    std::snprintf(text_, sizeof text_, "%s", text);
    return *this;
  }
  void clear() { text_[0] = '\0'; }
  const char* c_str() const { return text_; }

 private:
  char text_[1024];  // zero at first, as all thread-local memory is
};

}  // namespace chiasm
