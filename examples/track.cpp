// Objects followed through a video: a detector in one thread, a tracker in another, no copy between them.
//
//     track TRACKER DETECTOR FRAMES OUT.png     TRACKER: chiasm export ops.sort_track -o bundles;
//                                               DETECTOR: my.squares.chiasm, which track.py makes
#include <array>
#include <chiasm/opencv.hpp>
#include <future>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

struct Frame {  // and what is detected in it, in 8 slots
  cv::Mat pixels = cv::Mat(320, 320, CV_8UC3);
  std::array<float, 8 * 4> boxes;
  std::array<bool, 8> found;
};

int main(int count, char** arguments) try {
  if (count != 5) {
    std::cerr << "usage: track TRACKER DETECTOR FRAMES OUT.png\n";
    return 2;
  }
  const auto tracker = chiasm::Bundle::open(arguments[1]).method("forward");
  const auto detector = chiasm::Bundle::open(arguments[2]).method("forward");
  std::array<Frame, 2> frames;  // one is detected in while the other is tracked and drawn
  const auto detect = [&](int k) {
    auto& [pixels, boxes, found] = frames[k % 2];
    pixels.setTo(cv::Scalar::all(0));  // where a camera would write
    for (const cv::Point at : {cv::Point(4 * k, 40), cv::Point(240 - 4 * k, 180)})
      cv::rectangle(pixels, cv::Rect(at, cv::Size(64, 64)), cv::Scalar(0, 0, 255), cv::FILLED);
    detector.run_into({chiasm::view(pixels)}, {{boxes.data(), {1, 8, 4}}, {found.data(), {1, 8}}});
  };
  auto detected = std::async(std::launch::async, detect, 0);
  const std::vector<float> x(16 * 7), p(16 * 49);  // no tracks in 16 slots
  const std::vector<int64_t> counters(16 * 4), last(1);
  std::vector<chiasm::Tensor> state = {
      {x.data(), {1, 16, 7}}, {p.data(), {1, 16, 7, 7}}, {counters.data(), {1, 16, 4}}, {last.data(), {1}}};
  chiasm::Outputs tracks(nullptr);
  for (int k = 0; k < std::stoi(arguments[3]); ++k) {
    detected.get();
    detected = std::async(std::launch::async, detect, k + 1);
    auto& [pixels, boxes, found] = frames[k % 2];
    state.insert(state.end(), {{boxes.data(), {1, 8, 4}}, {found.data(), {1, 8}}});
    tracks = tracker.run(state);
    state = {tracks[0], tracks[1], tracks[2], tracks[3]};  // views, valid as long as the outputs
    for (size_t slot = 0; slot < 16; ++slot) {
      if (!tracks[6].data<bool>()[slot]) continue;
      const cv::Vec4i box = cv::Vec4f(tracks[4].data<float>() + 4 * slot);
      cv::rectangle(pixels, {box[0], box[1]}, {box[2], box[3]}, cv::Scalar::all(255));
      std::cout << tracks[2].data<int64_t>()[4 * slot] << ' ' << box << '\n';
    }
    if (!cv::imwrite(arguments[4], pixels))
      throw std::runtime_error("cannot write " + std::string(arguments[4]));
  }
} catch (const std::exception& error) {
  std::cerr << "track: " << error.what() << '\n';
  return 1;
}
