/** A forked child can run its parent's methods and load more, whatever the parent's other threads did at that
 *  moment. */
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <optional>
#include <thread>

#include "calls.h"
#include "child.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using std::chrono::seconds;

class Fork : public ::testing::TestWithParam<std::string> {
 protected:
  std::string way() const { return GetParam(); }
  LoadOptions with_own_threads(int count) const {
    const bool flat = way() == "onnx_flat";
    LoadOptions options = LoadOptions().with_backend(flat ? "onnx" : way()).with_num_threads(count);
    if (flat) options.with_option("fused", "0");
    return options;
  }
  const std::string sobel_ = bundle_path("filters.sobel"), edges_ = bundle_path("pipelines.edges");
  // Large enough for the threads of every engine.
  const Inputs image_ = make_inputs(Bundle::open(sobel_).methods().at(0), 1, 512);
  const Inputs frame_ = make_inputs(Bundle::open(edges_).methods().at(0), 2, 512);
};

std::vector<std::string> ways_of_the_runtime() {
  std::vector<std::string> ways = ways_to_call();
  ways.erase(std::remove(ways.begin(), ways.end(), "plugin"), ways.end());
  return ways;
}

std::string ok_if(bool right, const char* what) { return right ? "" : std::string(what) + " differs; "; }

INSTANTIATE_TEST_SUITE_P(Built, Fork, ::testing::ValuesIn(ways_to_call()),
                         [](const auto& info) { return info.param; });

TEST_P(Fork, AChildGoesOnWithWhatItsParentRan) {
  const Callable sobel = load(way(), sobel_);
  const std::string expected = sobel(image_);
  const std::string other = load(way(), edges_)(frame_);
  const Ending child = in_child(seconds(30), [&] {
    std::string wrong = ok_if(sobel(image_) == expected, "a method loaded before the fork");
    wrong += ok_if(load(way(), edges_)(frame_) == other, "a method loaded after it");
    wrong += ok_if(load(way(), sobel_)(image_) == expected, "the first, loaded again");
    const Ending grandchild =
        in_child(seconds(10), [&] { return ok_if(sobel(image_) == expected, "a grandchild's"); });
    return wrong + (grandchild.well() ? grandchild.words : "the grandchild: " + grandchild.text());
  });
  EXPECT_TRUE(child.well()) << child.text();
  EXPECT_EQ(child.words, "");
  EXPECT_EQ(sobel(image_), expected) << "in the parent, after the fork";
}

TEST_P(Fork, AChildEndsByExit) {
  if (way() == "plugin") GTEST_SKIP() << "the program's own environment is ONNX Runtime's to destroy";
  const Callable sobel = load(way(), sobel_);
  sobel(image_);
  const Ending child = in_child(seconds(30), []() -> std::string { std::exit(7); });
  EXPECT_FALSE(child.timed_out);
  EXPECT_EQ(child.code, 7) << child.text();
}

/** Not for `plugin`: the program's own session belongs to ONNX Runtime, and nobody can wait for its locks. */
class BusyFork : public Fork {};
INSTANTIATE_TEST_SUITE_P(Built, BusyFork, ::testing::ValuesIn(ways_of_the_runtime()),
                         [](const auto& info) { return info.param; });

TEST_P(BusyFork, WhileOtherThreadsRunAndLoad) {
  const Callable sobel = load(way(), sobel_);
  const std::string expected = sobel(image_);
  const Inputs small = make_inputs(Bundle::open(sobel_).methods().at(0), 3, 16);
  const std::string expected_small = sobel(small);
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([&, i] {
      while (!stop) {
        if (i == 0)
          load(way(), sobel_)(small);
        else
          sobel(i == 1 ? small : image_);
      }
    });
  }
  const int rounds = 16;
  std::string trouble;
  for (int round = 0; round < rounds && trouble.empty(); ++round) {
    const Ending child = in_child(seconds(30), [&] {
      std::string wrong = ok_if(sobel(small) == expected_small, "a small run");
      wrong += ok_if(sobel(image_) == expected, "a run");
      if (round % 4 == 0)
        wrong += ok_if(load(way(), sobel_)(image_) == expected, "a run of what the child loaded");
      return wrong;
    });
    if (!child.well() || !child.words.empty())
      trouble = "round " + std::to_string(round) + ": " + child.text();
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(trouble, "");
}

/** A method with its own threads, which do not exist in a child: there its pool ends without them. */
TEST_P(Fork, AChildClosesWhatItsParentLoaded) {
  if (way() == "plugin") GTEST_SKIP() << "a session of the program's own is ONNX Runtime's to close";
  std::optional<Method> sobel = Bundle::open(sobel_).method("forward", with_own_threads(3));
  const std::string expected = bytes_of(sobel->run(image_.tensors));
  const Ending child = in_child(seconds(30), [&] {
    std::string wrong = ok_if(bytes_of(sobel->run(image_.tensors)) == expected, "a run");
    sobel.reset();
    return wrong;
  });
  EXPECT_TRUE(child.well()) << child.text();
  EXPECT_EQ(child.words, "");
  EXPECT_EQ(bytes_of(sobel->run(image_.tensors)), expected) << "in the parent, after the fork";
}

/** The same with fewer threads than the process has, which are the method's own on any machine. */
TEST_P(Fork, AChildClosesAMethodWithAFewThreadsOfItsOwn) {
  if (way() == "plugin") GTEST_SKIP() << "a session of the program's own is ONNX Runtime's to close";
  const Ending process = in_child(seconds(60), [&] {
    try {
      set_num_threads(4);
    } catch (const Error&) {
      return std::string("loaded");
    }
    std::optional<Method> sobel = Bundle::open(sobel_).method("forward", with_own_threads(2));
    const std::string expected = bytes_of(sobel->run(image_.tensors));
    const Ending child = in_child(seconds(20), [&] {
      std::string wrong = ok_if(bytes_of(sobel->run(image_.tensors)) == expected, "a run");
      sobel.reset();
      return wrong;
    });
    return child.well() ? child.words : child.text();
  });
  EXPECT_TRUE(process.well()) << process.text();
  if (process.words == "loaded") GTEST_SKIP() << "a test before this one loaded a method: run it alone";
  EXPECT_EQ(process.words, "");
}

/** The policy's lock is not a gate's: who opens a bundle has it while keys are read. */
TEST(ForkOfTrust, WhileAnotherThreadReadsThePolicy) {
  const TemporaryFolder folder;
  const std::string key =
      folder.write("key.pub", "RWTw5+M+30ejPJL8tKbwCcT38wi9MhKN6gMYCUvWEFLwjJgIr0gKPa8T\n");
  const std::string bundle = bundle_path("filters.sobel");
  const Ending process = in_child(seconds(60), [&] {
    ::setenv("CHIASM_TRUST_POLICY", "any", 1);
    ::setenv("CHIASM_TRUSTED_KEYS", key.c_str(), 1);
    std::atomic<bool> stop{false};
    std::thread other([&] {
      while (!stop) Bundle::open(bundle);
    });
    std::string trouble;
    for (int i = 0; i < 1000 && trouble.empty(); ++i) {
      const Ending child = in_child(seconds(5), [&] {
        Bundle::open(bundle);
        return std::string();
      });
      if (!child.well()) trouble = "fork " + std::to_string(i) + ": " + child.text();
    }
    stop = true;
    other.join();
    return trouble;
  });
  EXPECT_TRUE(process.well()) << process.text();
  EXPECT_EQ(process.words, "");
}

/** The first use of a backend in a child, whose parent only opened a bundle. */
TEST_P(Fork, AChildMayBeTheFirstToLoad) {
  const Ending child = in_child(seconds(30), [&] {
    load(way(), sobel_)(image_);
    return std::string();
  });
  EXPECT_TRUE(child.well()) << child.text();
}

}  // namespace
}  // namespace chiasm::testing
