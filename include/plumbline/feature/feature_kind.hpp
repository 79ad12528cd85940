#pragma once
/// Concept of a feature kind: what a landmark and an observation of it are, and which rows they give. One store and one
/// set of terms serve all kinds (landmark_store.hpp, motion_terms.hpp, window_terms.hpp); its front end finds it in
/// images.
///
/// The functions of a kind are static and work on one landmark. Types:
///   Geometry     of a landmark in the camera of its anchor; `step` adds an increment of `dim` numbers
///   Observation  by one frame: `valid`; `place()` in the image; `scale_sigma`, `rescale`; with a rolling shutter also
///                `change_readout` and `set_motion`, and in the kind `set_motion_in_anchor` (row_motion.hpp)
///   Appearance   image data by which a landmark is recognized
///   InAnchor     what the costs of one landmark share, computed once from its geometry
///   Linearized   what its rows share
///   InWorld      a landmark in world coordinates with its observation by the latest frame
/// A row is whitened and multiplied by the square root of its robust weight; costs are 1/2 rho.

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Types and dimensions.
template <class K>
concept KindOfLandmark = std::floating_point<typename K::Scalar> && requires {
  typename K::Geometry;
  typename K::Appearance;
  typename K::Observation;
  typename K::Place;
  { K::dim } -> std::convertible_to<int>;            // dimension of the increment of a landmark
  { K::rows_per_view } -> std::convertible_to<int>;  // largest number of rows of one observation
  { K::damping_rows } -> std::convertible_to<int>;   // rows of `add_damping`
};

/// Operations on geometry and observations.
template <class K>
concept HasGeometry = requires(typename K::Geometry& geometry, const typename K::Observation& seen,
                               typename K::Observation& observation, typename K::Scalar s) {
  { K::middle(geometry) } -> std::convertible_to<Vec<typename K::Scalar, 3>>;  // in the anchor's camera [m]
  { K::inverse_range(geometry) } -> std::convertible_to<typename K::Scalar>;   // [1/m]
  { K::motion_px(seen, seen) } -> std::convertible_to<double>;                 // motion between two observations [px]
  { K::set_covariance(geometry, seen, nullptr) } -> std::same_as<bool>;  // after an optimization; false: remove it
  K::rescale(geometry, s);
  K::change_readout(geometry, seen, s);
  K::set_range_in_anchor(geometry, observation, s);  // its range has changed, see row_ranges.hpp
  K::set_range(geometry, observation, SE3<typename K::Scalar>{}, s);
  K::step(geometry, Vec<typename K::Scalar, K::dim>{});
};

/// Rows of pose refinement.
template <class K>
concept HasMotionRows = requires {
  typename K::InWorld;
  { K::depth_dim } -> std::convertible_to<int>;  // rows of a measured depth; 0: no `depth_rows`
};

/// A kind whose landmarks consist of landmarks of a kind before it, their members (`can_contain<Kind>`). Such landmarks
/// are not counted as features and do not contribute to the mean motion, because their members do.
template <class K>
concept HasMembers = requires {
  typename K::Member;
};

/// Everything that store and terms require of a kind.
template <class K>
concept FeatureKind = KindOfLandmark<K> && HasGeometry<K> && HasMotionRows<K>;

}  // namespace plumbline
