#pragma once
/// The largest image that the program's estimators have room for [px].

#include <cstddef>

inline constexpr std::size_t largest_image_px = 1920 * 1200;
