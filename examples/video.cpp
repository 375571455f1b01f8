// Frame after frame into the same memory: a run allocates nothing.
//
//     video BUNDLE FRAMES        BUNDLE: chiasm export pipelines.edges -o bundles; FRAMES: how many
#include <chiasm/opencv.hpp>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <opencv2/core.hpp>

int main(int count, char** arguments) try {
  if (count != 3) {
    std::cerr << "usage: video BUNDLE FRAMES\n";
    return 2;
  }
  const int frames = std::atoi(arguments[2]);
  chiasm::LoadOptions options;
  options.warm_up = true;
  const auto edges = chiasm::Bundle::open(arguments[1]).method("forward", options);
  cv::Mat frame(720, 1280, CV_8UC3),
      result(720, 1280, CV_8U);  // where a camera would write, and what we make of it
  int64_t total = 0;
  const auto started = std::chrono::steady_clock::now();
  for (int number = 0; number < frames; ++number) {
    frame.setTo(cv::Scalar::all(0));
    const int left = 10 * number % 1180;
    frame.colRange(left, left + 100).setTo(cv::Scalar::all(255));  // a bar that moves
    edges.run_into({chiasm::view(frame)}, {chiasm::view(result)});
    total += static_cast<int64_t>(cv::sum(result)[0]);
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - started;
  std::cerr << edges.backend() << ": " << taken.count() / frames << " ms a frame\n";
  std::cout << total << '\n';
} catch (const std::exception& error) {
  std::cerr << "video: " << error.what() << '\n';
  return 1;
}
