#pragma once
/// A recorded path of a body, as the truth of a real flight: poses between its samples by lie/interpolate.hpp.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/interpolate.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::testing {

class RecordedPath {
 public:
  struct Sample {
    TimeNs t_ns;
    SE3<double> T_world_body;
  };
  struct State {
    SE3<double> T_world_body;
  };
  /// Smallest axis-aligned box around the positions [m].
  struct Bounds {
    Vec<double, 3> min, max;
  };

  /// At least two samples in order of time. t = 0 is at `t_start_ns`.
  RecordedPath(std::vector<Sample> samples, TimeNs t_start_ns) : samples_(std::move(samples)), t_start_ns_(t_start_ns) {
    PLUMBLINE_ASSERT(samples_.size() >= 2);
  }

  /// The pose at t [s]; before the first and after the last sample, theirs.
  State at(double t) const {
    const TimeNs t_ns = t_start_ns_ + static_cast<TimeNs>(t * 1e9);
    const auto after = std::upper_bound(samples_.begin(), samples_.end(), t_ns,
                                        [](TimeNs time, const Sample& sample) { return time < sample.t_ns; });
    if (after == samples_.begin()) return {samples_.front().T_world_body};
    if (after == samples_.end()) return {samples_.back().T_world_body};
    const Sample &a = *(after - 1), &b = *after;
    const double part = double(t_ns - a.t_ns) / double(b.t_ns - a.t_ns);
    return {interpolate(a.T_world_body, b.T_world_body, part).T};
  }

  Bounds bounds() const {
    Bounds out{samples_.front().T_world_body.p(), samples_.front().T_world_body.p()};
    for (const Sample& sample : samples_) {
      out.min = out.min.cwiseMin(sample.T_world_body.p());
      out.max = out.max.cwiseMax(sample.T_world_body.p());
    }
    return out;
  }

  /// Moves the whole path by `offset` [m].
  void shift(const Vec<double, 3>& offset) {
    for (Sample& sample : samples_) {
      sample.T_world_body = SE3<double>(sample.T_world_body.rotation(), sample.T_world_body.p() + offset);
    }
  }

 private:
  std::vector<Sample> samples_;
  TimeNs t_start_ns_;
};

}  // namespace plumbline::testing
