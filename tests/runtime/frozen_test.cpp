/** Programs that were compiled with old headers run with the current library. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "support.h"

namespace chiasm::testing {
namespace {

/** The program's output, and a line with its status if that is not 0. */
std::string output_of(const std::string& program, const std::string& bundle) {
  const std::string command = "LD_LIBRARY_PATH=" CHIASM_LIBRARY_FOLDER
                              " CHIASM_BACKEND_PATH=" CHIASM_FAKE_FOLDER "/good " +
                              program + " " + bundle + " 2>&1";
  FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return "cannot be run";
  std::string text;
  std::array<char, 256> part;
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) text += part.data();
  const int status = ::pclose(pipe);
  return status == 0 ? text : text + "status " + std::to_string(status);
}

class Frozen : public ::testing::TestWithParam<std::string> {};

TEST_P(Frozen, RunsOnTheLibraryOfToday) {
  const TemporaryFolder folder;
  EXPECT_THAT(output_of(GetParam(), write_bundle(folder)),
              ::testing::MatchesRegex("version 1 on native: 118, [34] rows\n"));
}

std::vector<std::string> programs() {
  std::vector<std::string> all{CHIASM_FROZEN_PROGRAM};
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  all.emplace_back(CHIASM_FROZEN_FOLDER "/version_1/program.x86_64");
#endif
  return all;
}

INSTANTIATE_TEST_SUITE_P(Programs, Frozen, ::testing::ValuesIn(programs()), [](const auto& info) {
  return info.index == 0 ? "compiled_today" : "compiled_then";
});

}  // namespace
}  // namespace chiasm::testing
