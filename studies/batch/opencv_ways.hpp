// OpenCV's code for each work, image by image, with the settings with which the bundle was exported.
#pragma once

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace ways {

// The work on one image. It reuses its intermediate matrices, so each thread has its own.
using OnImage = std::function<void(const cv::Mat& image, cv::Mat& result)>;

inline cv::Scalar scalar(const nlohmann::json& values) { return {values.at(0), values.at(1), values.at(2)}; }

// For float32 images, RGB: the magnitude of the gradient in every channel.
inline OnImage sobel() {
  return [dx = cv::Mat(), dy = cv::Mat()](const cv::Mat& image, cv::Mat& result) mutable {
    cv::Sobel(image, dx, CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    cv::Sobel(image, dy, CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
    result.create(image.size(), image.type());
    cv::magnitude(dx.reshape(1), dy.reshape(1), result.reshape(1));
  };
}

// For frames: uint8, BGR.
inline OnImage edges() {
  return [grey = cv::Mat(), blurred = cv::Mat(), dx = cv::Mat(), dy = cv::Mat(), magnitude = cv::Mat()](
             const cv::Mat& frame, cv::Mat& result) mutable {
    cv::cvtColor(frame, grey, cv::COLOR_BGR2GRAY);
    cv::GaussianBlur(grey, blurred, {5, 5}, 1.0);
    cv::Sobel(blurred, dx, CV_32F, 1, 0);
    cv::Sobel(blurred, dy, CV_32F, 0, 1);
    cv::magnitude(dx, dy, magnitude);
    magnitude.convertTo(result, CV_8U);
  };
}

// For frames: uint8, BGR. The result is the planes R, G, B, one below the other.
inline OnImage preprocess() {
  const double mean[] = {0.485, 0.456, 0.406}, std[] = {0.229, 0.224, 0.225};  // pipelines.preprocess's own
  return
      [=, small = cv::Mat(), planes = std::vector<cv::Mat>()](const cv::Mat& frame, cv::Mat& result) mutable {
        cv::resize(frame, small, {224, 224}, 0, 0, cv::INTER_LINEAR);
        cv::split(small, planes);
        result.create(3 * small.rows, small.cols, CV_32F);
        for (int c = 0; c < 3; ++c)
          planes[2 - c].convertTo(result.rowRange(c * small.rows, (c + 1) * small.rows), CV_32F,
                                  1 / (255 * std[c]), -mean[c] / std[c]);
      };
}

// For float32 images, RGB: the five ops. The maps are made once.
inline OnImage prepare(const nlohmann::json& config, cv::Size size) {
  const std::vector<double> camera = config.at("camera"), lens = config.at("lens"),
                            jitter = config.at("jitter");
  const cv::Matx33d matrix(camera[0], 0, camera[2], 0, camera[1], camera[3], 0, 0, 1);
  cv::Mat map_x, map_y;
  cv::initUndistortRectifyMap(matrix, lens, {}, matrix, size, CV_32FC1, map_x, map_y);
  const cv::Size resized(config.at("size").at(1), config.at("size").at(0));
  const int taps = config.at("blur").at(0);
  const double sigma = config.at("blur").at(1), degrees = jitter[3] * 180 / CV_PI;
  const cv::Scalar mean = scalar(config.at("mean")), std = scalar(config.at("std")),
                   zero = cv::Scalar::all(0), one = cv::Scalar::all(1);
  cv::Matx33f colours;  // changes the saturation
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      colours(r, c) = float((r == c ? jitter[2] : 0) + (1 - jitter[2]) * (c == 0   ? 0.299
                                                                          : c == 1 ? 0.587
                                                                                   : 0.114));
  return [=, straight = cv::Mat(), x = cv::Mat(), y = cv::Mat(), grey = cv::Mat(), hsv = cv::Mat(),
          hue = cv::Mat(), beyond = cv::Mat()](const cv::Mat& image, cv::Mat& result) mutable {
    cv::remap(image, straight, map_x, map_y, cv::INTER_LINEAR);
    cv::resize(straight, x, resized, 0, 0, cv::INTER_LINEAR);
    x.convertTo(x, -1, jitter[0]);
    cv::min(x, one, x);
    cv::cvtColor(x, grey, cv::COLOR_RGB2GRAY);
    x.convertTo(x, -1, jitter[1], cv::mean(grey)[0] * (1 - jitter[1]));
    cv::max(x, zero, x);
    cv::min(x, one, x);
    cv::transform(x, y, colours);
    cv::max(y, zero, y);
    cv::min(y, one, y);
    cv::cvtColor(y, hsv, cv::COLOR_RGB2HSV);
    cv::extractChannel(hsv, hue, 0);
    cv::add(hue, degrees, hue);
    cv::threshold(hue, beyond, 360, 360, cv::THRESH_BINARY);
    cv::subtract(hue, beyond, hue);
    cv::insertChannel(hue, hsv, 0);
    cv::cvtColor(hsv, x, cv::COLOR_HSV2RGB);
    cv::GaussianBlur(x, y, {taps, taps}, sigma, sigma);
    cv::subtract(y, mean, x);
    cv::divide(x, std, result);
  };
}

inline OnImage named(const std::string& work, const nlohmann::json& config, cv::Size size) {
  if (work == "sobel") return sobel();
  if (work == "edges") return edges();
  if (work == "preprocess") return preprocess();
  if (work == "prepare") return prepare(config, size);
  throw std::runtime_error("there is no work " + work);
}

}  // namespace ways
