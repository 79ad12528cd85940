#include "plumbline/camera/any_camera.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("any_camera: behaves as the camera it holds", "", float, double) {
  using S = TestType;
  const Pinhole<S> pinhole{500, 510, 320, 240};
  const Pinhole<S, RadTan> radtan{500, 510, 320, 240, {S(-0.28), S(0.07), S(2e-4), S(1e-4)}};
  const Equidistant<S> equidistant(250, 251, 320, 240, S(-0.01), S(0.002));
  const DoubleSphere<S> double_sphere(200, 201, 320, 240, S(-0.2), S(0.59));
  const Pinhole<S, Rational> rational{500, 510, 320, 240, {S(0.1), S(0.01), 0, 0, 0, S(0.3), S(0.02), 0}};
  const Pinhole<S, Fov> fov{400, 402, 320, 240, {S(0.9)}};
  const Omni<S> omni{700, 701, 320, 240, S(1.2), {S(-0.1), S(0.02), 0, 0}};
  const Eucm<S> eucm(200, 201, 320, 240, S(0.6), S(1.1));
  const auto same = [](const AnyCamera<S>& any, const auto& camera, std::size_t index) {
    CHECK(any.model().index() == index);
    for (int v = 0; v < 480; v += 60) {
      for (int u = 0; u < 640; u += 80) {
        const Vec<S, 2> uv{S(u), S(v)};
        const auto a = any.unproject(uv);
        const auto b = camera.unproject(uv);
        REQUIRE((a.valid && b.valid));
        CHECK(a.bearing == b.bearing);
        const auto pa = any.project(a.bearing), pb = camera.project(b.bearing);
        REQUIRE((pa.valid && pb.valid));
        CHECK(pa.uv == pb.uv);
        CHECK(pa.J_uv_p == pb.J_uv_p);
      }
    }
    CHECK(!any.project({0, 0, -1}).valid);
  };
  same(pinhole, pinhole, 0);
  same(radtan, radtan, 1);
  same(equidistant, equidistant, 2);
  same(double_sphere, double_sphere, 3);
  same(rational, rational, 4);
  same(fov, fov, 5);
  same(omni, omni, 6);
  same(eucm, eucm, 7);
}

TEMPLATE_TEST_CASE("any_camera: camera suite and assignment", "", float, double) {
  AnyCamera<TestType> camera;  // the unit pinhole
  CHECK(camera.project({1, 2, 4}).uv == Vec<TestType, 2>(TestType(0.25), TestType(0.5)));
  camera = Pinhole<TestType>{2, 2, 1, 1};
  CHECK(camera.project({1, 2, 4}).uv == Vec<TestType, 2>(TestType(1.5), TestType(2)));
  const auto make = [](auto s) {
    using S = decltype(s);
    return AnyCamera<S>(Pinhole<S, RadTan>{500, 510, 320, 240, {S(-0.28), S(0.07), S(2e-4), S(1e-4)}});
  };
  testing::check_camera<TestType>(make, 640, 480, 320, 240);
}
