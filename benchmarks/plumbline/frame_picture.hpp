#pragma once
/// A frame as an engineer looks at it: the image, its features by their state, and below it what they add up to.

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "marks.hpp"

/// Points are circles, edges segments, each with a tail to where it was in the frame before; what is rejected or lost
/// is crossed out. Colors: located green, not located yet blue, rejected red, lost yellow; the counts below have the
/// same. `headline` is ASCII.
cv::Mat frame_picture(const cv::Mat& gray, const std::vector<Mark>& marks, const std::string& headline);
