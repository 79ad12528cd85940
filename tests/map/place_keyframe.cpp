#include "plumbline/map/place_keyframe.hpp"

#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {

template <class S>
PlaceKeyframe<S, 8> keyframe() {
  PlaceKeyframe<S, 8> out;
  out.T_world_body = SE3<S>(SO3<S>::exp({S(0.1), S(0.2), S(-0.3)}), {S(1), S(2), S(3)});
  out.T_body_cam = SE3<S>(SO3<S>::exp({S(0), S(0.5), S(0)}), {S(0.1), S(0), S(0)});
  out.covariance = out.Q = identity<S, 6>();
  for (const float range : {2.0f, 0.0f, 4.0f}) {
    PlaceFeature feature;
    feature.range = range;
    feature.sigma_range = 0.1f * range;
    out.features.push_back(feature);
  }
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("place_keyframe: with its world its camera moves, and all lengths take the new unit", "", float,
                   double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(1e-5) : S(1e-12);
  const PlaceKeyframe<S, 8> before = keyframe<S>();
  PlaceKeyframe<S, 8> after = before;
  const Sim3<S> X(S(2), SO3<S>::exp({S(0), S(0.3), S(1)}), {S(5), S(-1), S(0)});
  const SE3<S> T_body_cam(SO3<S>::exp({S(0.2), S(0), S(0)}), {S(0), S(0.3), S(0)});
  after.transform(X, T_body_cam);
  const SE3<S> old_cam = before.T_world_body * before.T_body_cam, new_cam = after.T_world_body * after.T_body_cam;
  CHECK(norm(Vec<S, 3>(new_cam.p() - X * old_cam.p())) < tolerance);
  CHECK((new_cam.R() - X.R() * old_cam.R()).norm() < tolerance);
  CHECK(after.T_body_cam.p() == T_body_cam.p());
  for (const Mat<S, 6, 6>* P : {&after.covariance, &after.Q}) {
    CHECK(((*P)(0, 0) == S(1) && (*P)(2, 2) == S(1)));  // an angle has no unit
    CHECK(((*P)(3, 3) == S(4) && (*P)(5, 5) == S(4)));
  }
  CHECK((after.features[2].range == 8 && after.features[2].sigma_range == Approx(0.8f)));
  CHECK_FALSE(after.features[1].is_located());
  CHECK(after.is_new);  // the pose graph has the edge of before
}

TEMPLATE_TEST_CASE("place_keyframe: the mean range is of the features that have one", "", float, double) {
  PlaceKeyframe<TestType, 8> some = keyframe<TestType>();
  CHECK(some.mean_range() == TestType(3));
  some.features.clear();
  CHECK(some.mean_range() == TestType(1));
  some.features.push_back({});
  CHECK(some.mean_range() == TestType(1));
}
