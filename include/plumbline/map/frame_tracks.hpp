#pragma once
/// Points of the map that are followed from image to image while nothing else is tracked: a blurred image shows no
/// descriptor that the map knows, but it shows the points of the image before.                   docs/math/map.md 6

#include <cstddef>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace plumbline {

/// A point of the map in the image that was seen last.
template <class S>
struct FrameTrack {
  Vec<S, 3> p_map = zeros<S, 3>();          ///< in the unit of the map
  Vec<float, 2> pixel = zeros<float, 2>();  ///< [px]
  PlaceFeature in_keyframe;                 ///< as the local map had it: its sigmas
};

template <class S, std::size_t N>
class FrameTracks {
 public:
  static constexpr float distance_px = 6;  ///< between two tracks; geometry: half of a patch of the optical flow

  std::span<const FrameTrack<S>> tracks() const { return {tracks_.data(), tracks_.size()}; }
  std::size_t size() const { return tracks_.size(); }
  void clear() { tracks_.clear(); }

  /// Follows the points from the previous image to the current one, if they were seen in it. `R_cur_prev` is the
  /// rotation that is expected of the camera.
  template <class View>
  void follow(const View& view, const SO3<S>& R_cur_prev, const OpticalFlowOptions& options) {
    constexpr double same_s = 1e-6;  // numerics: of a difference of time stamps
    if (image_ != &view.previous || !(seconds_between(t_ns_, view.t_ns) < double(view.dt) + same_s)) tracks_.clear();
    image_ = &view.current;
    t_ns_ = view.t_ns;
    for (std::size_t i = tracks_.size(); i-- > 0;) {
      Vec<float, 2>& pixel = tracks_[i].pixel;
      const auto ray = view.camera().unproject(cast_to<S>(pixel));
      const auto expected = view.camera().project(Vec<S, 3>(R_cur_prev * ray.bearing));
      const bool is_expected = ray.valid && expected.valid &&
                               view.current.level(0).contains(float(expected.uv.x()), float(expected.uv.y()), 0.0f);
      const FlowResult flow = track_point_checked(view.previous, view.current, pixel,
                                                  is_expected ? cast_to<float>(expected.uv) : pixel, options);
      pixel = flow.uv;
      if (!flow.valid || view.current.mask().excludes(pixel)) tracks_.swap_remove(i);
    }
  }
  /// Adds a point that the current image shows there, unless another one is near.
  void add(const FrameTrack<S>& track) {
    for (const FrameTrack<S>& other : tracks_) {
      if (squared_norm(Vec<float, 2>(other.pixel - track.pixel)) < distance_px * distance_px) return;
    }
    (void)tracks_.push_back(track);
  }
  /// Keeps those with keep(index).
  void keep_if(auto&& keep) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      if (keep(i)) tracks_[kept++] = tracks_[i];
    }
    tracks_.resize(kept);
  }

 private:
  FixedVector<FrameTrack<S>, N> tracks_;
  const void* image_ = nullptr;  ///< in which they were seen
  TimeNs t_ns_ = 0;              ///< of it
};

}  // namespace plumbline
