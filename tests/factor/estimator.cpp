// Factors by way of the estimator: which frames take one, and what that changes.                  docs/math/factors.md
#include "plumbline/estimator/estimator.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {
using Sensors = Rig<Rgbd<Pinhole<float>, 64 * 64>>;
using With = Estimator<Sensors, Features<Points<20>>, SlidingWindow<3, Flow, AbsolutePosition>>;
using Without = Estimator<Sensors, Features<Points<20>>, SlidingWindow<3>>;

template <class Vo, class F>
concept CanAddFactor = requires(Vo& vo, const F& factor) {
  vo.add_factor(factor);
};
static_assert(CanAddFactor<With, AbsolutePosition<float>> && !CanAddFactor<With, AbsolutePosition<double>>);
static_assert(!CanAddFactor<Without, AbsolutePosition<float>>);
static_assert(sizeof(Without) < sizeof(With) && sizeof(With) < sizeof(Without) + 512);
}  // namespace

TEST_CASE("estimator: no factor before there is a keyframe") {
  const auto vo = std::make_unique<With>(Sensors{});
  CHECK(!vo->add_factor(AbsolutePosition<float>{{0, 0, 0}, Mat<float, 3, 3>::Identity()}));
}
