#pragma once
/// The inverse of a lens distortion by Newton's method.                                    docs/math/camera.md

#include <concepts>
#include <limits>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// m and d m / d m' of a distortion policy, from m'; invalid where it finds no point of the domain.
template <std::floating_point S, class Distortion>
typename NoDistortion<S>::Distorted newton_inverse(const Distortion& distortion, const Vec<S, 2>& m_distorted) {
  constexpr S tolerance = 8 * std::numeric_limits<S>::epsilon();
  typename NoDistortion<S>::Distorted out;
  out.valid = false;
  out.m = m_distorted;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto forward = distortion.distort(out.m);
    const S det = forward.J(0, 0) * forward.J(1, 1) - forward.J(0, 1) * forward.J(1, 0);
    if (!(det > 0)) return out;
    out.J << forward.J(1, 1), -forward.J(0, 1), -forward.J(1, 0), forward.J(0, 0);
    out.J = out.J / det;
    const Vec<S, 2> step = out.J * Vec<S, 2>(m_distorted - forward.m);
    out.valid = forward.valid && squared_norm(step) <= tolerance * tolerance * (1 + squared_norm(out.m));
    if (out.valid) return out;
    out.m += step;
  }
  return out;
}

}  // namespace plumbline
