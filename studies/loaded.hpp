// Lets the C++ programs of the use cases inspect their own process.
#pragma once

#include <fstream>
#include <string>

// Whether a library whose name has this prefix is loaded in this process.
inline bool loaded(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find('/' + library) != std::string::npos) return true;
  return false;
}
