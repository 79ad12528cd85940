#include "plumbline/frontend/front_end.hpp"

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/frontend/edge_following.hpp"
#include "plumbline/frontend/initialization_flow.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

namespace {

template <class Sensors>
using Points = LandmarkStore<PointKind<Sensors>, 16, 3>;
template <class Sensors>
using Lines = LandmarkStore<LineKind<Sensors>, 16, 3>;
template <class Sensors>
using Window = FrameWindow<typename Sensors::Scalar, VisualLayout, 3>;

template <class Sensors>
constexpr bool all_are_front_ends = FrontEnd<PointFlow<Points<Sensors>>, Points<Sensors>, Window<Sensors>>&&
    FrontEnd<InitializationFlow<Points<Sensors>>, Points<Sensors>, Window<Sensors>>&&
        FrontEnd<EdgeFollowing<Lines<Sensors>>, Lines<Sensors>, Window<Sensors>>;

using MonoRig = Rig<Mono<Pinhole<float>, 64 * 64>>;
using RgbdRig = Rig<Rgbd<Pinhole<double>, 64 * 64>>;
static_assert(all_are_front_ends<MonoRig> && all_are_front_ends<RgbdRig>);

/// Sees, but finds nothing new.
struct WithoutCorrespondences {
  struct Options {};
  explicit WithoutCorrespondences(const Options&) {}
  static constexpr bool gives_correspondences = false;
  void follow(const auto&, const auto&, auto&, const auto&) {}
  void refine(const auto&, const auto&, auto&, const auto&) {}
  void locate(const auto&, const auto&, auto&, const auto&) {}
};
struct Promised : WithoutCorrespondences {
  using WithoutCorrespondences::WithoutCorrespondences;
  static constexpr bool gives_correspondences = true;
  void detect(const auto&, const auto&, auto&, int) {}
};
struct WithCorrespondences : Promised {
  using Promised::Promised;
  void for_each_correspondence(const auto&, const auto&, const auto&, auto&&) const {}
};
static_assert(!FrontEnd<WithoutCorrespondences, Points<MonoRig>, Window<MonoRig>>);
static_assert(!FrontEnd<Promised, Points<MonoRig>, Window<MonoRig>>);
static_assert(FrontEnd<WithCorrespondences, Points<MonoRig>, Window<MonoRig>>);
static_assert(!FrontEnd<PointKind<MonoRig>, Points<MonoRig>, Window<MonoRig>>);

}  // namespace

TEST_CASE("front_end: points give correspondences for a pose, lines do not") {
  STATIC_REQUIRE(GivesCorrespondences<PointFlow<Points<MonoRig>>>);
  STATIC_REQUIRE(GivesCorrespondences<InitializationFlow<Points<MonoRig>>>);
  STATIC_REQUIRE_FALSE(GivesCorrespondences<EdgeFollowing<Lines<MonoRig>>>);
  STATIC_REQUIRE(GivesCorrespondences<WithCorrespondences>);
  STATIC_REQUIRE_FALSE(GivesCorrespondences<WithoutCorrespondences>);
}
