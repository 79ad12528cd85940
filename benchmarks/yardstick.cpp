// What OpenCV's optical flow costs on a recording: buildOpticalFlowPyramid, then calcOpticalFlowPyrLK of 150 points
// forth and back, 21x21 window, 3 levels, one thread. Decoding is not counted. Prints the median of all frames.
//
//   yardstick DATASET_DIR [--frames N]
//
// DATASET_DIR has the layout of TUM (rgb.txt) or of EuRoC (mav0/cam0/data.csv).

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace {

/// The image files named in the second column of the index, after blanks or a comma.
std::vector<std::string> image_files(const std::string& dataset) {
  std::string folder = dataset + "/";
  std::ifstream index(folder + "rgb.txt");
  if (!index) {
    folder = dataset + "/mav0/cam0/data/";
    index.open(dataset + "/mav0/cam0/data.csv");
  }
  std::vector<std::string> files;
  for (std::string line; std::getline(index, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t separator = line.find_first_of(", \t");
    const std::size_t first = line.find_first_not_of(", \t", separator);
    if (first == std::string::npos) continue;
    files.push_back(folder + line.substr(first, line.find_last_not_of(" \t\r") + 1 - first));
  }
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  const bool has_frames = argc == 4 && std::string(argv[2]) == "--frames";
  if (argc != 2 && !has_frames) {
    std::fprintf(stderr, "usage: yardstick DATASET_DIR [--frames N]\n");
    return 2;
  }
  std::vector<std::string> files = image_files(argv[1]);
  if (has_frames) files.resize(std::min(files.size(), static_cast<std::size_t>(std::max(0, std::atoi(argv[3])))));
  if (files.size() < 2) {
    std::fprintf(stderr, "yardstick: %s: fewer than two images (neither rgb.txt nor mav0/cam0/data.csv?)\n", argv[1]);
    return 1;
  }
  cv::setNumThreads(1);
  const cv::Size window(21, 21);
  constexpr int levels = 3, points = 150;
  std::vector<double> milliseconds;
  std::vector<cv::Mat> previous_pyramid, current_pyramid;
  cv::Mat previous;
  for (const std::string& file : files) {
    const cv::Mat current = cv::imread(file, cv::IMREAD_GRAYSCALE);
    if (current.empty()) {
      std::fprintf(stderr, "yardstick: cannot read %s\n", file.c_str());
      return 1;
    }
    std::vector<cv::Point2f> corners, there, back;
    if (!previous.empty()) cv::goodFeaturesToTrack(previous, corners, points, 0.001, 10);
    const auto start = std::chrono::steady_clock::now();
    cv::buildOpticalFlowPyramid(current, current_pyramid, window, levels);
    if (!corners.empty()) {
      std::vector<unsigned char> found;
      std::vector<float> error;
      cv::calcOpticalFlowPyrLK(previous_pyramid, current_pyramid, corners, there, found, error, window, levels);
      cv::calcOpticalFlowPyrLK(current_pyramid, previous_pyramid, there, back, found, error, window, levels);
      const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
      milliseconds.push_back(elapsed.count());
    }
    previous = current;
    std::swap(previous_pyramid, current_pyramid);
  }
  if (milliseconds.empty()) {
    std::fprintf(stderr, "yardstick: no corners in any image\n");
    return 1;
  }
  const auto median = milliseconds.begin() + static_cast<std::ptrdiff_t>(milliseconds.size() / 2);
  std::nth_element(milliseconds.begin(), median, milliseconds.end());
  std::printf("%.3f ms per frame (median of %zu)\n", *median, milliseconds.size());
  return 0;
}
