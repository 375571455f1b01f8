/** Tests thousands of damaged bundles:
 *
 *      mutants COUNT [FIRST [JOBS]]      the mutants FIRST to FIRST + COUNT - 1, JOBS at a time
 *
 *  Each is opened, loaded in every way and run with inputs that fit its signature, in a child process with
 *  limits. It must end with an error or a result. Unless it is a mutant with other data, the result must be
 *  that of the undamaged bundle. Other mutants are listed and kept in the folder mutants-found/. */
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "calls.h"
#include "child.h"
#include "mutate.h"
#include "support.h"

namespace {

using namespace chiasm::testing;
using chiasm::Bundle;
using chiasm::Error;
using chiasm::MethodInfo;
using chiasm::TensorInfo;

constexpr const char* kNames[] = {"filters.sobel", "pipelines.edges", "color.rgb_to_grayscale"};
constexpr auto kLimit = std::chrono::seconds(60);
constexpr size_t kMemory = size_t{3} << 30;  // above what the engines' libraries take

/** The parts of a method's description that determine inputs and outputs. */
std::string text_of(const MethodInfo& method) {
  std::string text = method.name;
  const auto add = [&text](const std::vector<TensorInfo>& tensors) {
    text += " |";
    for (const TensorInfo& tensor : tensors) {
      text += " " + tensor.name;
      for (const auto dtype : tensor.dtypes) text += std::string(",") + name(dtype);
      for (const auto& dim : tensor.dims)
        text += "," + dim.expression + ":" + std::to_string(dim.min) + ":" + std::to_string(dim.max);
      text += "," + std::to_string(tensor.value_min) + ":" + std::to_string(tensor.value_max);
    }
  };
  add(method.inputs);
  add(method.outputs);
  return text;
}

/** The ways under the core's control; tests/parity/test_ort.py tests the program's own sessions. TorchScript
 *  takes as long to load as all others together, so two thirds of the mutants skip it. */
std::vector<std::string> ways(uint64_t number) {
  std::vector<std::string> all;
  for (const std::string& way : ways_to_call())
    if (way != "plugin" && (way != "torch" || number / std::size(kNames) % 3 == 0)) all.push_back(way);
  return all;
}

/** The results of the ways, by the bundle's position and the signature. If an artifact is missing, a way may
 *  use another one. */
using Answers = std::map<std::string, std::set<std::string>>;

/** Opens and runs everything possible. Returns the number of results, then the problems with them. Results
 *  are compared with `answers`, or added to it if `record` is true. */
std::string attack(const std::string& folder, size_t which, uint64_t number, Answers& answers, bool record,
                   bool compare) {
  int answered = 0;
  std::optional<Bundle> bundle;
  try {
    bundle = Bundle::open(folder);
  } catch (const Error&) {
    return "0 ";
  }
  std::string wrong;
  for (const MethodInfo& method : bundle->methods()) {
    for (const std::string& way : ways(number)) {
      std::string answer;
      try {
        const Callable call = load(way, folder, method.name);
        answer = call(make_inputs(method, 7, 24));
      } catch (const Error&) {
        continue;
      } catch (const std::runtime_error&) {  // of make_inputs
        continue;
      }
      ++answered;
      const std::string key = std::to_string(which) + " " + text_of(method);
      if (record) answers[key].insert(sha256_of(answer));
      const auto found = answers.find(key);
      if (compare && found != answers.end() && found->second.count(sha256_of(answer)) == 0)
        wrong += way + ": " + method.name + " answers differently; ";
    }
  }
  try {
    if (number / std::size(kNames) % 4 == 0) bundle->self_test();
  } catch (const Error&) {}
  return std::to_string(answered) + " " + wrong;
}

void limit_memory() {
  size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit limit{pages * static_cast<size_t>(::sysconf(_SC_PAGESIZE)) + kMemory, RLIM_INFINITY};
  ::setrlimit(RLIMIT_AS, &limit);
}

/** Silences output: engines print their errors. */
void hush() {
  std::fflush(stderr);
  static_cast<void>(std::freopen("/dev/null", "w", stderr));
}

int run(uint64_t first, uint64_t count, int job, int jobs) {
  std::vector<Files> bundles;
  Answers answers;
  for (const char* name : kNames) bundles.push_back(read_bundle(bundle_path(name)));
  // In a child too, so that this process has the engines' libraries but no threads: its children begin like a
  // new program.
  const Ending original = in_child(std::chrono::minutes(3), [&] {
    Answers all;
    for (size_t i = 0; i < bundles.size(); ++i)
      if (std::stoul(attack(bundle_path(kNames[i]), i, 0, all, true, false)) < ways(0).size())
        throw std::runtime_error(std::string("not every way answers for ") + kNames[i]);
    std::string text;
    for (const auto& [key, ways] : all)
      for (const std::string& answer : ways) text += key + "\t" + answer + "\n";
    return text;
  });
  if (!original.well()) {
    std::printf("mutants: the undamaged bundles: %s\n", original.text().c_str());
    return 1;
  }
  std::istringstream lines(original.words);
  for (std::string line; std::getline(lines, line);)
    answers[line.substr(0, line.find('\t'))].insert(line.substr(line.find('\t') + 1));
  chiasm::backends();  // opened here once, not by each child

  const TemporaryFolder scratch;
  int failures = 0, tried = 0, answering = 0;
  for (uint64_t number = first + static_cast<uint64_t>(job); number < first + count;
       number += static_cast<uint64_t>(jobs)) {
    const size_t which = number % bundles.size();
    const Mutant mutant = mutant_of(bundles, which, number);
    const std::string folder = scratch.path() + "/" + kNames[which] + ".chiasm";
    write_bundle(folder, mutant.files);
    const Ending ending = in_child(kLimit, [&] {
      hush();
      limit_memory();
      chiasm::set_num_threads(2);
      return attack(folder, which, number, answers, false, !mutant.other_data);
    });
    const std::string wrong =
        ending.words.substr(std::min(ending.words.find(' '), ending.words.size() - 1) + 1);
    ++tried;
    if (std::atoi(ending.words.c_str()) > 0) ++answering;
    if (ending.well() && wrong.empty()) continue;
    ++failures;
    std::printf("mutants: %llu of %s: %s\n    %s\n", static_cast<unsigned long long>(number), kNames[which],
                ending.text().c_str(), mutant.description.c_str());
    std::fflush(stdout);
    std::filesystem::create_directories("mutants-found");
    write_bundle("mutants-found/" + std::to_string(number) + "." + kNames[which] + ".chiasm", mutant.files);
  }
  std::printf("mutants: job %d: %d tried, %d of them still answer, %d failed\n", job, tried, answering,
              failures);
  return failures == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const auto number = [&](int i, uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const uint64_t count = number(1, 300), first = number(2, 0);
  const int jobs = static_cast<int>(number(3, 2));
  std::vector<pid_t> children;
  for (int job = 0; job < jobs; ++job) {
    const pid_t child = ::fork();
    if (child == 0) {
      const int result = run(first, count, job, jobs);
      std::fflush(stdout);
      ::_exit(result);
    }
    children.push_back(child);
  }
  bool failed = false;
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) std::printf("mutants: a job itself ended by signal %d\n", WTERMSIG(status));
    failed = failed || !WIFEXITED(status) || WEXITSTATUS(status) != 0;
  }
  std::printf("mutants: %llu from %llu on: %s\n", static_cast<unsigned long long>(count),
              static_cast<unsigned long long>(first), failed ? "FAILED" : "passed");
  return failed ? 1 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "mutants: %s\n", error.what());
  return 1;
}
