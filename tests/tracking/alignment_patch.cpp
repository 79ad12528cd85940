#include "plumbline/tracking/alignment_patch.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

/// A smooth image, so that differences over a small motion are derivatives.
struct Smooth {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(64 * 64);
  Smooth(double phase = 0) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        pixels[std::size_t(y * 64 + x)] =
            std::uint8_t(128 + 60 * std::sin(0.21 * x + phase) * std::cos(0.17 * y) + 40 * std::sin(0.11 * (x + y)));
      }
    }
  }
  ImageView<const std::uint8_t> view() const { return {pixels.data(), 64, 64, 64}; }
};

struct Equations {
  Mat<double, 8, 8> H = Mat<double, 8, 8>::Zero();
  Vec<double, 8> b = Vec<double, 8>::Zero();
};

}  // namespace

TEMPLATE_TEST_CASE("alignment_patch: the motion of a pixel by the motion of the body", "", float, double) {
  using S = TestType;
  const Pinhole<S> camera{S(200), S(210), S(160), S(120), {}};
  const Pinhole<double> exact{200, 210, 160, 120, {}};
  const SE3<double> T_cam_body(SO3<double>::exp({0.2, -1.1, 0.7}), {0.05, -0.02, 0.1});
  const SE3<double> T_cur_prev(SO3<double>::exp({0.05, 0.02, -0.04}), {0.1, 0.03, -0.05});
  const Vec<double, 3> p_body = T_cam_body.inverse() * Vec<double, 3>(0.4, -0.3, 2.5);
  const auto uv = [&](const SE3<double>& T) { return exact.project(T_cam_body * (T * p_body)).uv; };
  for (const SE3<double>& T : {SE3<double>(), T_cur_prev}) {
    const SE3<S> T_cam_prev = (T_cam_body * T).cast<S>();
    const auto projection = camera.project(T_cam_prev * Vec<S, 3>(p_body.cast<S>()));
    REQUIRE(projection.valid);
    const Mat<S, 2, 6> M = motion_jacobian(projection.J_uv_p, T_cam_prev.R(), Vec<S, 3>(p_body.cast<S>()));
    REQUIRE(testing::jacobian_error(M, uv, T) < (sizeof(S) == 4 ? 1e-5 : 1e-9));
  }
}

TEST_CASE("alignment_patch: equations are those of its rows, one by one") {
  const Smooth previous, current(0.3);
  AlignmentPatch patch;
  patch.capture(previous.view(), {30.3f, 25.8f});
  REQUIRE(patch.valid);
  patch.M << 3, -1, 2, 0.5f, 1, -2, 1, 2, -3, 1, 0.3f, 0.7f;
  const float gain = 0.1f, bias = 3, weight = 0.7f;
  patch.compare(current.view(), {31.1f, 25.2f}, gain, bias, false);
  REQUIRE(patch.visible);
  Equations fast, slow;
  patch.add_to(fast, gain, weight);
  Patch<4> I;
  interpolate_patch<4>(current.view(), {31.1f, 25.2f}, I);
  double squares = 0;
  for (int j = 0; j < AlignmentPatch::samples; ++j) {
    const double r = I[j] - (1 + gain) * patch.intensity[j] - bias;
    Vec<double, 8> row;
    row << (1 + gain) * (patch.gx[j] * patch.M.row(0) + patch.gy[j] * patch.M.row(1)).transpose().cast<double>(),
        -patch.intensity[j], -1;
    slow.H += weight * row * row.transpose();
    slow.b += weight * row * r;
    squares += r * r;
  }
  CHECK(patch.error == Approx(std::sqrt(squares / AlignmentPatch::samples)).epsilon(1e-4));
  for (int j = 0; j < 8; ++j) {
    CHECK(fast.b[j] == Approx(slow.b[j]).epsilon(1e-3).margin(1e-2 * slow.b.norm() * 1e-2));
    for (int i = 0; i <= j; ++i) CHECK(fast.H(i, j) == Approx(slow.H(i, j)).epsilon(1e-4).margin(1e-4 * slow.H(j, j)));
  }
}

TEST_CASE("alignment_patch: the gradient is that of the residual, of the previous or of the current image") {
  const Smooth previous, current(0.1);
  const Vec<float, 2> at(30.2f, 31.6f);
  const auto sum_of = [&](const Vec<float, 2>& center) {
    Patch<4> I;
    interpolate_patch<4>(current.view(), center, I);
    return I.sum();
  };
  AlignmentPatch patch;
  patch.capture(previous.view(), at);
  patch.compare(current.view(), at, 0, 0, /*forward=*/true);
  REQUIRE(patch.visible);
  const float step = 1;  // central differences of the image are what gradients are
  CHECK(patch.gx.sum() ==
        Approx((sum_of({at.x() + step, at.y()}) - sum_of({at.x() - step, at.y()})) / 2).epsilon(1e-3));
  CHECK(patch.gy.sum() ==
        Approx((sum_of({at.x(), at.y() + step}) - sum_of({at.x(), at.y() - step})) / 2).epsilon(1e-3));
}

TEST_CASE("alignment_patch: at the edge of an image, and nowhere") {
  const Smooth image;
  AlignmentPatch patch;
  for (const Vec<float, 2>& at : {Vec<float, 2>(1, 30), Vec<float, 2>(62.5f, 30), Vec<float, 2>(std::nanf(""), 30)}) {
    patch.capture(image.view(), at);
    CHECK_FALSE(patch.valid);
    patch.compare(image.view(), at, 0, 0, false);
    CHECK_FALSE(patch.visible);
  }
}
