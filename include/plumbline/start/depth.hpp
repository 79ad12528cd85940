#pragma once
/// Start of a camera with depth: the first frame that shows enough locates its landmarks, in metres.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
struct DepthStart {
  static constexpr bool needs_second_view = false;
  struct Options {};
  explicit DepthStart(const Options&) {}
  DepthStart& visual() { return *this; }
};

}  // namespace plumbline
