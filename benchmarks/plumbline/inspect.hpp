#pragma once
/// Reads an Inspection off an estimator, through what it shows to everyone.

#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "inspection.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/residual/world_line.hpp"
#include "plumbline/residual/world_point.hpp"

/// `r` with its covariance; none where that is not positive definite.
template <class S>
std::optional<Innovation> innovation_of(const plumbline::Vec<S, 2>& r, double px,
                                        const plumbline::Mat<S, 2, 2>& covariance) {
  const auto L = plumbline::square_root_information(covariance);
  if (!L) return std::nullopt;
  return Innovation{px, double((*L * r).norm())};
}

/// Of one landmark whose anchor's camera is at T_world_cam; covariances as in the motion-only estimate: the
/// observation's, after its frame's own scale, and that of the landmark.
template <class Sensors, class Landmark>
std::optional<Innovation> innovation_of(const Sensors& rig, const plumbline::SE3<typename Sensors::Scalar>& T_world_cam,
                                        const plumbline::BodyView<typename Sensors::Scalar>& view,
                                        const Landmark& landmark) {
  using S = typename Sensors::Scalar;
  using Mat2 = plumbline::Mat<S, 2, 2>;
  if constexpr (requires { landmark.line; }) {
    const auto& seen = landmark.current.pixels;
    const auto lin = plumbline::WorldLine<plumbline::LineReprojection<S>>{seen}.linearize(
        view, T_world_cam * landmark.line.plucker());
    if (!lin.valid) return std::nullopt;
    const plumbline::Mat<S, 2, 4> J =
        lin.J_r_line * plumbline::plucker_transform(T_world_cam) * landmark.line.plucker_jacobian();
    const Mat2 covariance = landmark.current.pixels_covariance + J * landmark.covariance * J.transpose();
    return innovation_of<S>(lin.r, double(lin.r.norm()) / std::sqrt(2.0), covariance);
  } else {
    const auto lin =
        plumbline::PointReprojection<typename Sensors::Camera>{landmark.current.uv.template cast<S>()}.linearize(
            rig.vision.camera, view, T_world_cam * landmark.p_anchor_cam());
    if (!lin.valid) return std::nullopt;
    const plumbline::Vec<S, 3> sigma_cam =
        landmark.p_anchor_cam() * (landmark.sigma_inverse_range / landmark.inverse_range);
    const plumbline::Vec<S, 2> j = lin.J_r_point * (T_world_cam.rotation() * sigma_cam);
    const Mat2 L = landmark.current.L.template cast<S>();  // lower triangular
    Mat2 L_inverse;
    L_inverse << 1 / L(0, 0), 0, -L(1, 0) / (L(0, 0) * L(1, 1)), 1 / L(1, 1);
    return innovation_of<S>(lin.r, double(lin.r.norm()), L_inverse * L_inverse.transpose() + j * j.transpose());
  }
}

template <class Map>
FeatureInspection inspect_features(const Map& map) {
  FeatureInspection out{};
  out.are_lines = requires(const typename Map::Landmark& landmark) { landmark.line; };
  out.landmarks = map.landmarks().size();
  const auto sighting = [](std::uint32_t id, bool located, const auto& place) -> Sighting {
    if constexpr (requires { place.segment; })
      return {id, located, place.segment.start, place.segment.end};
    else
      return {id, located, place.pixel, place.pixel};
  };
  for (const auto& landmark : map.landmarks()) {
    if (landmark.current.valid) out.seen.push_back(sighting(landmark.id, landmark.located, landmark.current));
  }
  for (const auto& rejected : map.rejected()) out.rejected.push_back(sighting(rejected.id, true, rejected));
  return out;
}

template <class S>
plumbline::Estimate<double> to_double(const plumbline::Estimate<S>& e) {
  return {e.t_ns,
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

/// `previous_ns`: time of the frame before the latest.
template <class Estimator>
Inspection inspect(const Estimator& estimator, plumbline::TimeNs previous_ns) {
  using S = typename Estimator::S;
  const auto& rig = estimator.rig();
  Inspection out{to_double(estimator.latest()), double(estimator.readout().value_s), {}, std::nullopt};
  bool has_pose = out.estimate.health.state != plumbline::HealthState::initializing;
  if constexpr (std::remove_cvref_t<decltype(rig)>::has_imu) {
    const plumbline::TimeNs offset_ns = std::llround(1e9 * rig.imu.camera_time_offset_s);
    InertialInspection inertial{
        estimator.init_report(), estimator.at_rest(),
        estimator.imu().for_each_interval(previous_ns + offset_ns, out.estimate.t_ns + offset_ns, [](const auto&) {}),
        std::nullopt};
    has_pose = inertial.start.stage == plumbline::InitStage::done;  // before, map and pose are of two worlds
    plumbline::Mat<S, 15, 15> covariance;
    if (has_pose && estimator.backend().newest_covariance(covariance))
      inertial.sigma = covariance.diagonal().template tail<9>().cwiseSqrt().template cast<double>();
    out.inertial = inertial;
  }
  const auto& window = estimator.backend().window();
  const plumbline::BodyView<S> view(estimator.latest().T_world_body, rig.T_body_cam());
  estimator.features().for_each([&](const auto& map) {
    FeatureInspection features = inspect_features(map);
    for (const auto& landmark : map.landmarks()) {
      const bool just_found = out.estimate.keyframe && landmark.anchor == window.newest();  // where it was seen
      if (!has_pose || !landmark.current.valid || !landmark.located || just_found) continue;
      const auto innovation =
          innovation_of(rig, window[landmark.anchor].pose.value() * rig.T_body_cam(), view, landmark);
      if (innovation) features.innovations.push_back(*innovation);
    }
    out.features.push_back(std::move(features));
  });
  return out;
}
