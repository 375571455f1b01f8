/** Random damage to a bundle. */
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace chiasm::testing {

/** The files of a bundle by their names. */
using Files = std::map<std::string, std::string>;

Files read_bundle(const std::string& folder);
void write_bundle(const std::string& folder, const Files& files);

struct Mutant {
  Files files;
  std::string description;
  /** Whether a file's bytes were changed together with their hash: this is other data, which may give other
   *  results. */
  bool other_data = false;
};

/** The `number`-th mutant of the bundles, always the same. The bytes of code (native, TorchScript) are never
 *  changed together with their hash, because that would be another program. */
Mutant mutant_of(const std::vector<Files>& bundles, size_t which, uint64_t number);

}  // namespace chiasm::testing
