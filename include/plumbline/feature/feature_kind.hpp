#pragma once
/// A kind of feature: what a landmark and an observation of it are, and which rows they give. One store and one set of
/// terms serve all kinds (landmark_store.hpp, motion_terms.hpp, window_terms.hpp); how a kind is found in images is for
/// its front end.
///
/// The functions of a kind are static and work on one landmark at a time. Their semantics:
///   Geometry     of a landmark in the camera of its anchor; `step` moves it by an increment of `dim` numbers
///   Observation  where one frame saw it: `valid`; `place()` in the image; `scale_sigma`, `rescale`; of a shutter that
///                rolls `change_readout` and `set_motion`, as `set_motion_in_anchor` with the geometry (row_motion.hpp)
///   Appearance   by which it is recognized
///   InAnchor     what the costs of one landmark share, made once for them of its geometry
///   Linearized   what its rows share
///   InWorld      a landmark in world coordinates together with what the latest frame saw of it
/// A row is whitened and multiplied with the square root of its robust weight; costs are 1/2 rho.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class K>
concept KindOfLandmark = std::floating_point<typename K::Scalar> && requires {
  typename K::Geometry;
  typename K::Appearance;
  typename K::Observation;
  typename K::Place;
  { K::dim } -> std::convertible_to<int>;            // of a landmark's increment
  { K::rows_per_view } -> std::convertible_to<int>;  // at most, of one observation
  { K::damping_rows } -> std::convertible_to<int>;   // that hold a landmark in a step
};

/// Lengths, motions and what becomes of a landmark.
template <class K>
concept HasGeometry = requires(typename K::Geometry& geometry, const typename K::Observation& seen,
                               typename K::Observation& observation, typename K::Scalar s) {
  { K::middle(geometry) } -> std::convertible_to<Vec<typename K::Scalar, 3>>;  // in the anchor's camera [m]
  { K::inverse_range(geometry) } -> std::convertible_to<typename K::Scalar>;   // [1/m]
  { K::motion_px(seen, seen) } -> std::convertible_to<double>;                 // from one frame to another
  { K::settle(geometry, seen, nullptr) } -> std::same_as<bool>;                // after an optimization
  K::rescale(geometry, s);
  K::change_readout(geometry, seen, s);
  K::set_range_in_anchor(geometry, observation, s);  // its distance has changed: see row_ranges.hpp
  K::set_range(geometry, observation, SE3<typename K::Scalar>{}, s);
  K::step(geometry, Vec<typename K::Scalar, K::dim>{});
};

/// Rows of the estimate of one frame, its map being given.
template <class K>
concept HasMotionRows = requires {
  typename K::InWorld;
  { K::depth_dim } -> std::convertible_to<int>;  // rows of a measured depth; 0: there is none, and no `depth_rows`
};

/// Its landmarks hold those of a kind before it (`holds<Kind>`), its members. They are counted by these: what carries
/// an estimate, and how far the image moved, they say once.
template <class K>
concept HoldsOthers = requires {
  typename K::Member;
};

template <class K>
concept FeatureKind = KindOfLandmark<K> && HasGeometry<K> && HasMotionRows<K>;

}  // namespace plumbline
