#include "plumbline/tracking/patch_template.hpp"

#include <limits>
#include <vector>

#include <Eigen/QR>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// A smooth image that is known between its pixels.
double intensity(double x, double y) {
  return 120 + 30 * std::sin(0.31 * x + 0.1 * y) + 35 * std::cos(0.27 * y - 0.12 * x) +
         10 * std::sin(0.5 * x - 0.4 * y);
}

struct SmoothImage {
  SmoothImage(double dx, double dy, double gain, double bias) : pixels(100 * 100) {
    for (int y = 0; y < 100; ++y) {
      for (int x = 0; x < 100; ++x) {
        pixels[std::size_t(y * 100 + x)] = static_cast<std::uint8_t>(gain * intensity(x - dx, y - dy) + bias + 0.5);
      }
    }
  }
  ImageView<const std::uint8_t> view() const { return {pixels.data(), 100, 100, 100}; }
  std::vector<std::uint8_t> pixels;
};

template <int Size>
PatchTemplate<Size> template_at(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& uv,
                                bool with_gain = true) {
  typename PatchTemplate<Size>::Bordered bordered;
  interpolate_patch<PatchTemplate<Size>::bordered_size>(image, uv, bordered);
  PatchTemplate<Size> patch;
  patch.set(bordered, with_gain);
  return patch;
}

}  // namespace

TEST_CASE("patch template: information is the Schur complement of the joint problem") {
  const SmoothImage image(0, 0, 1, 0);
  constexpr int size = 10, samples = size * size;
  for (const bool with_gain : {true, false}) {
    const Vec<float, 2> uv(41.3f, 52.8f);
    const PatchTemplate<size> patch = template_at<size>(image.view(), uv, with_gain);
    // Joint Jacobian [dT/du, dT/dv, -T, -1] by differences of interpolated patches.
    Mat<double, samples, 4> J;
    Patch<size> plus, minus;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec<float, 2> d = Vec<float, 2>::Unit(axis);
      interpolate_patch<size>(image.view(), uv + d, plus);
      interpolate_patch<size>(image.view(), uv - d, minus);
      J.col(axis) = (plus - minus).cast<double>() / 2;
    }
    interpolate_patch<size>(image.view(), uv, plus);
    J.col(2) = -plus.cast<double>();
    J.col(3).setConstant(-1);
    if (!with_gain) J.col(2).setZero();
    const Mat<double, 4, 4> H = J.transpose() * J;
    const Mat<double, 2, 2> brightness = H.bottomRightCorner<2, 2>();
    const Mat<double, 2, 2> schur =
        H.topLeftCorner<2, 2>() -
        H.topRightCorner<2, 2>() *
            brightness.completeOrthogonalDecomposition().solve(H.bottomLeftCorner<2, 2>()).eval();
    REQUIRE((patch.information().cast<double>() - schur).norm() < 1e-4 * schur.norm());
    const double mean = (schur(0, 0) + schur(1, 1)) / 2, gap = (schur(0, 0) - schur(1, 1)) / 2;
    const double smallest = mean - std::sqrt(gap * gap + schur(0, 1) * schur(0, 1));
    REQUIRE(patch.min_eigenvalue() == Approx(smallest / samples).epsilon(1e-3));
  }
}

TEST_CASE("patch template: finds position, gain and residual") {
  const SmoothImage reference(0, 0, 1, 0);
  for (const double gain : {0.7, 1.0, 1.2}) {
    const SmoothImage current(1.37, -0.81, gain, 12);
    const Vec<float, 2> uv(45, 50), truth(46.37f, 49.19f);
    const PatchTemplate<12> patch = template_at<12>(reference.view(), uv);
    const PatchMatch match = patch.search(current.view(), uv, PatchSearch{});
    REQUIRE(match.valid);
    REQUIRE((match.uv - truth).norm() < 0.02f);
    REQUIRE(match.gain == Approx(gain).epsilon(0.02));
    REQUIRE(match.rms < 0.8f);  // quantization and interpolation
  }
}

TEST_CASE("patch template: along a direction only that component moves") {
  const SmoothImage reference(0, 0, 1, 0), current(1.0, 0.5, 1, 8);
  const Vec<float, 2> uv(45, 50), n = Vec<float, 2>(0.6f, 0.8f);
  const PatchTemplate<10> patch = template_at<10>(reference.view(), uv, false);
  const Vec<float, 2> start = uv + Vec<float, 2>(1.0f, 0.5f) + 1.5f * n;  // off along n alone
  const PatchMatch match = patch.search_along(current.view(), start, n, PatchSearch{});
  REQUIRE(match.valid);
  REQUIRE((match.uv - uv - Vec<float, 2>(1.0f, 0.5f)).norm() < 0.05f);
  const Vec<float, 2> across(-n.y(), n.x());
  REQUIRE(std::abs(across.dot(match.uv - start)) < 1e-4f);
}

TEST_CASE("patch template: fails out of bounds, on NaN and without convergence") {
  const SmoothImage reference(0, 0, 1, 0);
  const PatchTemplate<8> patch = template_at<8>(reference.view(), Vec<float, 2>(45, 50));
  REQUIRE_FALSE(patch.search(reference.view(), Vec<float, 2>(-1, 50), PatchSearch{}).valid);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  REQUIRE_FALSE(patch.search(reference.view(), Vec<float, 2>(nan, 50), PatchSearch{}).valid);
  REQUIRE_FALSE(patch.search(reference.view(), Vec<float, 2>(47, 50), PatchSearch{10, 0.01f, 0.5f}).valid);
  REQUIRE_FALSE(patch.search(reference.view(), Vec<float, 2>(47, 50), PatchSearch{1, 0.01f, 4.0f}).valid);
  REQUIRE(patch.search(reference.view(), Vec<float, 2>(46, 50), PatchSearch{}).valid);
}

TEST_CASE("patch template: without contrast the gain is not estimated") {
  const std::vector<std::uint8_t> flat(100 * 100, 90);
  const ImageView<const std::uint8_t> view{flat.data(), 100, 100, 100};
  const PatchTemplate<8> patch = template_at<8>(view, Vec<float, 2>(50, 50));
  REQUIRE(patch.min_eigenvalue() == 0.0f);
  REQUIRE_FALSE(patch.search(view, Vec<float, 2>(50, 50), PatchSearch{}).valid);  // a singular system, not a result
}
