#pragma once
/// Pairs of bearings of two views of a simulated scene, with noise and wrong pairs.

#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::testing {

enum class TwoViewKind { general, plane, rotation, forward, fisheye, turned };

struct TwoViewScene {
  static constexpr std::size_t capacity = 200;
  static constexpr double pixel = 1.0 / 460;  ///< [rad]

  SE3<double> T_2_1;
  Vec<double, 3> n_1;  ///< n_1 . p = 1 on the plane, if it is one
  FixedVector<BearingPair<double>, capacity> pairs;
  std::array<bool, capacity> wrong{};

  /// The image is 752 x 480 pixels at f = 460, and sees both ends of a pair. Not so the kinds `fisheye`, of 200
  /// degrees, and `turned`, by half a radian. Both bearings are noisy.
  TwoViewScene(TwoViewKind kind, std::uint64_t seed, double sigma_rad, double wrong_part) {
    Gaussian noise(stream_seed(seed, 1));
    Random random(stream_seed(seed, 2));
    const auto uniform = [&](double a, double b) { return a + (b - a) * random.uniform(); };
    const auto in_image = [&] { return Vec<double, 3>{uniform(-0.81, 0.81), uniform(-0.52, 0.52), 1}; };
    const auto noisy = [&](const Vec<double, 3>& p) {
      return Vec<double, 3>((p.normalized() + sigma_rad * noise.vector<3>()).normalized());
    };
    const bool wide = kind == TwoViewKind::fisheye || kind == TwoViewKind::turned;
    Vec<double, 3> t = 0.3 * noise.vector<3>().normalized(), phi = 0.1 * noise.vector<3>();
    if (kind == TwoViewKind::rotation) t.setZero();
    if (kind == TwoViewKind::forward) t = Vec<double, 3>{0.02 * noise(), 0.02 * noise(), -0.5};
    if (kind == TwoViewKind::turned) phi = 0.5 * noise.vector<3>().normalized();
    T_2_1 = SE3<double>(SO3<double>::exp(phi), t);
    n_1 = Vec<double, 3>{0.5 * noise(), 0.5 * noise(), 1}.normalized() / uniform(2, 4);
    for (int tries = 0; tries < 100000 && !pairs.full(); ++tries) {
      Vec<double, 3> p = in_image();
      if (kind == TwoViewKind::fisheye) {
        const double angle = uniform(0, 1.75), around = uniform(-3.14, 3.14);
        p = Vec<double, 3>(std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle));
      }
      p *= kind == TwoViewKind::plane ? 1 / n_1.dot(p) : uniform(1.2, 8);
      if (!(p.norm() > 0.3 && p.norm() < 30) || (!wide && p.z() < 0)) continue;
      Vec<double, 3> q = T_2_1 * p;
      const bool seen = q.z() > 0.2 && std::abs(q.x()) < 0.82 * q.z() && std::abs(q.y()) < 0.53 * q.z();
      if (!wide && !seen) continue;
      wrong[pairs.size()] = random.uniform() < wrong_part;
      if (wrong[pairs.size()]) q = in_image();
      pairs.push_back({noisy(p), noisy(q)});
    }
  }

  template <class S>
  FixedVector<BearingPair<S>, capacity> pairs_as() const {
    FixedVector<BearingPair<S>, capacity> out;
    for (const BearingPair<double>& pair : pairs) {
      out.push_back({pair.f1.template cast<S>(), pair.f2.template cast<S>()});
    }
    return out;
  }
  template <class S>
  double rotation_error(const SE3<S>& found) const {
    return (found.rotation().template cast<double>().inverse() * T_2_1.rotation()).log().norm();
  }
  /// Angle between the translations.
  template <class S>
  double direction_error(const SE3<S>& found) const {
    const Vec<double, 3> t = found.p().template cast<double>();
    return std::atan2(t.cross(T_2_1.p()).norm(), t.dot(T_2_1.p()));
  }
  SE3<double> unit_T_2_1() const { return SE3<double>(T_2_1.rotation(), T_2_1.p().normalized()); }
};

}  // namespace plumbline::testing
