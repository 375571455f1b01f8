// Many requests at once, a thread each: a method with one thread wakes no others and waits for none.
//
//     server BUNDLE REQUESTS        BUNDLE: chiasm export pipelines.edges -o bundles; REQUESTS: how many
#include <atomic>
#include <chiasm/opencv.hpp>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <mutex>
#include <opencv2/core.hpp>
#include <thread>

int main(int count, char** arguments) try {
  if (count != 3) {
    std::cerr << "usage: server BUNDLE REQUESTS\n";
    return 2;
  }
  const int requests = std::atoi(arguments[2]);
  chiasm::LoadOptions options;
  options.num_threads = 1;
  const auto edges =
      chiasm::Bundle::open(arguments[1]).method("forward", options);  // for many threads at once
  std::vector<int64_t> answers(static_cast<size_t>(requests));
  std::atomic<int> next{0};
  const auto serve = [&] {
    cv::Mat frame(240, 320, CV_8UC3), result(240, 320, CV_8U);
    for (int number = next++; number < requests; number = next++) {
      frame.setTo(cv::Scalar::all(0));
      const cv::Range square(20, 30 + number % 200);
      frame(square, square).setTo(cv::Scalar::all(200));
      edges.run_into({chiasm::view(frame)}, {chiasm::view(result)});
      answers[static_cast<size_t>(number)] = static_cast<int64_t>(cv::sum(result)[0]);
    }
  };
  std::exception_ptr failure;  // an exception that leaves a thread would end the process
  std::mutex mutex;
  const auto work = [&] {
    try {
      serve();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  for (size_t i = 0; i < answers.size(); ++i) std::cout << (i ? " " : "") << answers[i];
  std::cout << '\n';
} catch (const std::exception& error) {
  std::cerr << "server: " << error.what() << '\n';
  return 1;
}
