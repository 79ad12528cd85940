#pragma once
/// Reads an Inspection off an estimator, through what it shows to everyone.

#include <cmath>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "inspection.hpp"
#include "plumbline/feature/landmark_ties.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/residual/world_point.hpp"

/// How far a landmark's observation is from where the pose has it: by the whitened rows of the estimate of one frame,
/// with the covariances of both.
template <class Kind, class Sensors, class Landmark>
std::optional<Innovation> innovation_of(const Sensors& rig,
                                        const plumbline::SE3<typename Sensors::Scalar>& T_world_anchor,
                                        const plumbline::BodyView<typename Sensors::Scalar>& view,
                                        const Landmark& landmark) {
  const auto in_world = Kind::in_world(landmark.geometry, landmark.current, T_world_anchor);
  const auto rows = Kind::pixel_rows(rig, view, in_world);
  if (!rows.valid) return std::nullopt;
  return Innovation{Kind::error_px(rig, view, in_world), double(rows.r.norm())};
}

template <class Store>
FeatureInspection inspect_features(const Store& store) {
  using Place = typename Store::Kind::Place;
  FeatureInspection out{};
  out.are_lines = std::is_same_v<Place, plumbline::LineSegment>;
  out.name = plumbline::HasMembers<typename Store::Kind> ? "collinear" : out.are_lines ? "lines" : "points";
  out.landmarks = store.landmarks().size();
  const auto sighting = [](std::uint32_t id, bool located, const Place& place) -> Sighting {
    if constexpr (std::is_same_v<Place, plumbline::LineSegment>)
      return {id, located, place.start, place.end};
    else
      return {id, located, place, place};
  };
  for (const auto& landmark : store.landmarks()) {
    if (landmark.current.valid) out.seen.push_back(sighting(landmark.id, landmark.located, landmark.current.place()));
  }
  for (const auto& rejected : store.rejected()) out.rejected.push_back(sighting(rejected.id, true, rejected.place));
  return out;
}

template <class S>
plumbline::Estimate<double> to_double(const plumbline::Estimate<S>& e) {
  return {e.t_ns,
          e.time_offset_s,
          e.T_body_cam.template cast<double>(),
          e.T_world_body.template cast<double>(),
          e.covariance.template cast<double>(),
          e.v_world_body.template cast<double>(),
          e.bias_gyro.template cast<double>(),
          e.bias_accel.template cast<double>(),
          e.health,
          e.tracked,
          e.keyframe,
          e.resets};
}

/// Where the camera sits, as the window found it; before there is one, how it seems to be turned.
template <class Estimator>
void inspect_extrinsics(const Estimator& estimator, InertialInspection& out) {
  const auto deviation = [](const auto& T, const auto& calibrated) {
    return std::pair(
        plumbline::Vec<double, 3>((T.rotation() * calibrated.rotation().inverse()).log().template cast<double>()),
        plumbline::Vec<double, 3>((T.p() - calibrated.p()).template cast<double>()));
  };
  const auto& window = estimator.backend().window();
  const auto calibrated = estimator.rig().T_body_cam();
  std::tie(out.turned, out.moved) = deviation(estimator.rig_state().T_body_cam(), calibrated);
  out.corrects_extrinsics = window.estimates_extrinsics();
  plumbline::Mat<double, 6, 6> C;
  if (out.corrects_extrinsics && estimator.backend().covariance_of_extrinsics(C)) {
    const plumbline::Mat<double, 3, 3> R = estimator.rig_state().T_body_cam().R().template cast<double>();
    out.sigma_turned = (R * C.topLeftCorner<3, 3>() * R.transpose()).diagonal().cwiseSqrt();
    out.sigma_moved = (R * C.bottomRightCorner<3, 3>() * R.transpose()).diagonal().cwiseSqrt();
  } else {
    out.turned += estimator.camera_imu().rotation_error();
    out.sigma_turned.setConstant(estimator.camera_imu().rotation_sigma());
  }
}

/// `previous_ns`: time of the frame before the latest.
template <class Estimator>
Inspection inspect(const Estimator& estimator, plumbline::TimeNs previous_ns) {
  using S = typename Estimator::S;
  const auto& rig = estimator.rig();
  Inspection out{to_double(estimator.latest()), double(estimator.rig_state().readout().value_s), {}, std::nullopt};
  bool has_pose = out.estimate.health.state != plumbline::HealthState::initializing;
  if constexpr (std::remove_cvref_t<decltype(rig)>::has_imu) {
    const plumbline::TimeNs offset_ns = std::llround(1e9 * estimator.rig_state().time_offset_s());
    InertialInspection inertial{
        estimator.init_report(),
        estimator.is_stationary(),
        estimator.imu().for_each_interval(previous_ns + offset_ns, out.estimate.t_ns + offset_ns, [](const auto&) {}),
        estimator.imu().gyro_full_scale(),
        estimator.imu().accel_full_scale(),
        std::nullopt,
        estimator.rig_state().time_offset_s() - rig.imu.camera_time_offset_s,
        estimator.camera_imu().time_offset_sigma()};
    estimator.backend().sigma_of_time_offset(inertial.sigma_time_offset_s);  // unless the filter is in charge
    inspect_extrinsics(estimator, inertial);
    has_pose = inertial.start.stage == plumbline::InitStage::done;  // before, map and pose are of two worlds
    plumbline::Mat<S, 15, 15> covariance;
    if constexpr (requires { estimator.backend().covariance_of_newest(covariance); }) {  // not of the pose alone
      if (has_pose && estimator.backend().covariance_of_newest(covariance))
        inertial.sigma = covariance.diagonal().template tail<9>().cwiseSqrt().template cast<double>();
    }
    out.inertial = inertial;
  }
  const auto& window = estimator.backend().window();
  const auto& T_body_cam = estimator.rig_state().T_body_cam();
  const plumbline::BodyView<S> view(estimator.latest().T_world_body, T_body_cam);
  estimator.landmarks().for_each([&](const auto& store) {
    using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
    FeatureInspection features = inspect_features(store);
    for (const auto& landmark : store.landmarks()) {
      const bool just_found = out.estimate.keyframe && landmark.anchor == window.newest();  // where it was seen
      if (!has_pose || !landmark.current.valid || !landmark.located || just_found) continue;
      const auto innovation =
          innovation_of<Kind>(rig, window.T_world_body(landmark.anchor) * T_body_cam, view, landmark);
      if (innovation) features.innovations.push_back(*innovation);
    }
    out.features.push_back(std::move(features));
  });
  return out;
}
