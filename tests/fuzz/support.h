/** What the fuzzers of whole bundles share: a real bundle in memory, and folders to spoil. */
#pragma once

#include <map>
#include <string>

namespace chiasm::fuzz {

/** Name to content, of the bundle in tests/fuzz/bundle. */
const std::map<std::string, std::string>& seed_bundle();

/** A folder on a file system in memory, of this process alone. */
const std::string& scratch_folder();

/** An empty folder NAME in there, in place of what was there. */
std::string fresh_folder(const std::string& name);

void write_file(const std::string& path, const std::string& content);

/** Write the seed bundle to this path. */
void write_seed(const std::string& path);

/** The fake backends are this process's backends. */
void use_fake_backends();

}  // namespace chiasm::fuzz
