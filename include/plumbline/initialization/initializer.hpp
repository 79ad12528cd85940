#pragma once
/// Concept of an initializer: from the first frames to states and landmarks, or what is missing. It is driven by
/// Initialization; which of its calls are made depends on the sensors.
///
///   with depth           none: the first frame with enough features gives a metric map
///   without              two views with parallax (SolvesTwoViews)
///   with an IMU          then poses and IMU are aligned (AlignsWithImu)

#include <concepts>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/layout.hpp"
#include "plumbline/state/rig_state.hpp"

namespace plumbline {

/// Two views: pairs of bearings are added again for each frame, until their relative pose is solved for.
template <class V, class S>
concept SolvesTwoViews = requires(V& views, const V& known, const Vec<S, 3>& f, const SO3<S>& R_2_1,
                                  InitReport& report) {
  views.clear_pairs();
  views.add_pair(f, f);
  { known.pairs() } -> std::convertible_to<int>;
  { known.has_expired(1.0) } -> std::convertible_to<bool>;  // age of the first view [s]
  { views.solve(R_2_1, report) } -> std::convertible_to<bool>;
  { known.T_1_2(S()) } -> std::convertible_to<SE3<S>>;
};

/// Alignment of a series of camera poses with the IMU. `options` has the members of InertialInitializerOptions.
template <class I, class Sensors, class S = typename Sensors::Scalar>
concept AlignsWithImu = requires(I& initializer, const I& known, TimeNs t_ns, const SE3<S>& T, InitReport& report,
                                 const Mat<S, 3, 3>& covariance, const Preintegration<S>& samples,
                                 const RigState<Sensors>& rig_state, const CameraImuFilter& filter,
                                 const NavState<S>& x) {
  { known.options() } -> std::same_as<const typename I::Options&>;
  initializer.clear();
  { initializer.add(t_ns, T, covariance, samples, rig_state) } -> std::convertible_to<bool>;
  initializer.correct(t_ns, T);
  { initializer.align(T, 9.81, report) } -> std::convertible_to<bool>;
  { known.is_contradicted() } -> std::convertible_to<bool>;
  { known.is_time_offset_known(filter, 1.0) } -> std::convertible_to<bool>;
  { initializer.verify_time_offset(0.0) } -> std::convertible_to<bool>;
  { known.is_plausible(x) } -> std::convertible_to<bool>;
  { known.has_estimate() } -> std::convertible_to<bool>;
  { known.scale() } -> std::convertible_to<S>;
  { known.scale_sigma() } -> std::convertible_to<double>;
  { known.gravity_sigma() } -> std::convertible_to<double>;
  { known.latest_velocity() } -> std::convertible_to<Vec<S, 3>>;
  { known.state_of(T, T) } -> std::convertible_to<NavState<S>>;
  { known.prior_on_biases() } -> std::convertible_to<Mat<double, 6, InertialLayout::dim>>;
};

/// An initializer that has two views.
template <class I, class S>
concept HasTwoViews = requires(I& initializer) {
  requires SolvesTwoViews<std::remove_cvref_t<decltype(initializer.visual())>, S>;
};

/// Every call to an initializer that the sensors give rise to.
template <class I, class Sensors>
concept Initializer = std::constructible_from<I, const typename I::Options&> && requires {
  { I::needs_second_view } -> std::convertible_to<bool>;
  requires !I::needs_second_view || HasTwoViews<I, typename Sensors::Scalar>;
  requires !Sensors::has_imu || AlignsWithImu<I, Sensors>;
};

}  // namespace plumbline
