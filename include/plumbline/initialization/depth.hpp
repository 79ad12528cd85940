#pragma once
/// Initializer of a camera with depth: the first frame with enough features gives a metric map.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
struct DepthInitializer {
  static constexpr bool needs_second_view = false;
  struct Options {};
  explicit DepthInitializer(const Options&) {}
  DepthInitializer& visual() { return *this; }
};

}  // namespace plumbline
