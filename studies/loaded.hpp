// What the C++ programs of the use cases say of their own process.
#pragma once

#include <fstream>
#include <string>

// Whether a library whose name begins so is in this process.
inline bool loaded(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find('/' + library) != std::string::npos) return true;
  return false;
}
