/** Shared code of the fuzzers of whole bundles: a real bundle in memory, and folders to damage. */
#pragma once

#include <map>
#include <string>

namespace chiasm::fuzz {

/** The files of the bundle in tests/fuzz/bundle, by name. */
const std::map<std::string, std::string>& seed_bundle();

/** A folder on a file system in memory, for this process only. */
const std::string& scratch_folder();

/** An empty folder NAME in it; an existing one is replaced. */
std::string fresh_folder(const std::string& name);

void write_file(const std::string& path, const std::string& content);

/** Write the seed bundle to this path. */
void write_seed(const std::string& path);

/** The fake backends are this process's backends. */
void use_fake_backends();

}  // namespace chiasm::fuzz
