#pragma once
// A camera that walks round a room with a keyframe map.

#include <memory>
#include <vector>

#include "plumbline/map/keyframe_map.hpp"
#include "simulated_places.hpp"

namespace plumbline::test {

constexpr int per_lap = 60;
constexpr std::size_t window = 8;

/// A camera that walks round a room, outward looking, and an odometry that turns too far.
template <class Residual, int MaxKeyframes = 200>
struct Laps {
  using Core = KeyframeMapCore<Residual, MaxKeyframes, 200, 30>;
  using S = typename Core::S;
  std::unique_ptr<Core> map;
  SimulatedPlaces places;
  double drift_rad = 0.002;  ///< each keyframe
  double scale = 1;          ///< of the odometry's unit
  SE3<double> T_world_true;  ///< of a world that begins elsewhere
  SE3<double> T_world_body, T_true;
  SE3<double> T_begin;  ///< of the odometry's world in that of the truth
  int first = 0;        ///< place on the lap where it begins
  std::uint32_t id = 0;
  std::vector<SE3<S>> poses;  ///< in the odometry's world
  double P = 0;               ///< variance of the odometry's heading

  explicit Laps(std::uint64_t seed, const KeyframeMapOptions& options = {})
      : map(std::make_unique<Core>(options)), places(seed) {
    places.furnish(1500, 6);
  }

  static SE3<double> at(int k) {
    const double a = 2 * 3.14159265358979 * k / per_lap;
    return looking_along(a, {2.5 * std::cos(a), 2.5 * std::sin(a), 0});
  }
  /// The camera is the body.
  void step() {
    const SE3<double> T = at(first + int(id));
    if (id == 0) {
      T_world_body = T_begin * T;
    } else {
      const SE3<double> moved = T_true.inverse() * T;
      T_world_body = T_world_body * SE3<double>(moved.rotation(), scale * moved.p()) *
                     SE3<double>(SO3<double>::exp({0, drift_rad, 0}), {0, 0, 0});
      P += drift_rad * drift_rad * 4;
    }
    T_true = T;
    Mat<S, 6, 6> covariance = zeros<S, 6, 6>();
    for (int k = 0; k < 6; ++k) covariance(k, k) = S(1e-6 + P * (1 + id));
    ++id;
    const SE3<S> T_world = T_world_body.template cast<S>();
    if (auto* keyframe = map->begin_keyframe(id, TimeNs(id) * 100'000'000, T_world, SE3<S>(), covariance)) {
      places.look(T, keyframe->features, scale);
      map->finish_keyframe();
    }
    poses.push_back(T_world);
    if (id > window) map->retire(id - std::uint32_t(window), poses[id - window - 1]);
    for (int frame = 0; frame < 6; ++frame) map->work();
  }
  double world_error() const { return norm(Vec<double, 3>(T_world_body.p() - T_true.p())); }
  double map_error() const {
    const Sim3<double> T = map->S_map_world().template cast<double>() * Sim3<double>(T_world_body);
    return norm(Vec<double, 3>(T.t() - T_true.p()));
  }
};

}  // namespace plumbline::test
