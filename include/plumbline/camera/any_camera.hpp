#pragma once
/// One of the library's cameras, chosen at run time: what programs use so that one estimator serves every data set.

#include <concepts>
#include <variant>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/camera/double_sphere.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/eucm.hpp"
#include "plumbline/camera/fov.hpp"
#include "plumbline/camera/omni.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/camera/rational.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <std::floating_point S>
class AnyCamera {
 public:
  using Scalar = S;
  using Model = std::variant<Pinhole<S>, Pinhole<S, RadTan>, Equidistant<S>, DoubleSphere<S>, Pinhole<S, Rational>,
                             Pinhole<S, Fov>, Omni<S>, Eucm<S>>;

  AnyCamera() : model_(Pinhole<S>{1, 1, 0, 0}) {}
  template <CameraModel Camera>
  requires std::constructible_from<Model, Camera> AnyCamera(const Camera& camera) : model_(camera) {}

  Projection<S> project(const Vec<S, 3>& p_cam) const {
    return visit([&](const auto& camera) { return camera.project(p_cam); });
  }
  Unprojection<S> unproject(const Vec<S, 2>& uv) const {
    return visit([&](const auto& camera) { return camera.unproject(uv); });
  }

  const Model& model() const { return model_; }

 private:
  /// A switch instead of std::visit, which throws.
  auto visit(auto&& f) const {
    switch (model_.index()) {
      case 1: return f(*std::get_if<1>(&model_));
      case 2: return f(*std::get_if<2>(&model_));
      case 3: return f(*std::get_if<3>(&model_));
      case 4: return f(*std::get_if<4>(&model_));
      case 5: return f(*std::get_if<5>(&model_));
      case 6: return f(*std::get_if<6>(&model_));
      case 7: return f(*std::get_if<7>(&model_));
      default: return f(*std::get_if<0>(&model_));
    }
  }

  Model model_;
};

static_assert(CameraModel<AnyCamera<float>> && CameraModel<AnyCamera<double>>);

}  // namespace plumbline
