#include "plumbline/feature/feature_kind.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

template <class Sensors>
constexpr bool has_both_kinds = FeatureKind<PointKind<Sensors>>&& FeatureKind<LineKind<Sensors>>;

static_assert(has_both_kinds<Rig<Mono<Pinhole<float>>>>);
static_assert(has_both_kinds<Rig<Mono<Pinhole<double, RadTan>, 64 * 64, Rolling>, Imu>>);
static_assert(has_both_kinds<Rig<Rgbd<Pinhole<float, RadTan>>, Imu>>);
static_assert(has_both_kinds<Rig<Rgbd<Pinhole<double>, 64 * 64, Global>>>);

using Points = PointKind<Rig<Mono<Pinhole<float>>>>;

/// Kinds that lack something; each fails the part of the concept that names it.
struct WithoutDimension : Points {
 private:
  static constexpr int dim = 1;
};
struct WithoutLength : Points {
 private:
  static void rescale(Geometry&, float) {}
};
struct VerifiesNothing : Points {
  static void set_covariance(Geometry&, const Observation&, const Mat<float, 1, 1>*) {}  // returns no bool
};
struct NotInTheWorld : Points {
 private:
  struct InWorld {};
};

/// A kind with another kernel.
struct Cautious : Points {
  static constexpr Huber<float> pixel_loss{1.0f};
};

static_assert(!KindOfLandmark<WithoutDimension> && !FeatureKind<WithoutDimension>);
static_assert(KindOfLandmark<WithoutLength> && !HasGeometry<WithoutLength> && !FeatureKind<WithoutLength>);
static_assert(!HasGeometry<VerifiesNothing> && !FeatureKind<VerifiesNothing>);
static_assert(HasGeometry<NotInTheWorld> && !HasMotionRows<NotInTheWorld> && !FeatureKind<NotInTheWorld>);
static_assert(!FeatureKind<Pinhole<float>> && !FeatureKind<float>);

}  // namespace

TEST_CASE("feature_kind: a kind inherits defaults") {
  STATIC_REQUIRE(FeatureKind<Cautious>);
  REQUIRE(Cautious::pixel_loss.weight(4.0f) < Points::pixel_loss.weight(4.0f));
}
