// Nothing in imu/ allocates: neither through Eigen (checked also in release builds) nor through operator new.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/imu/stationarity.hpp"
#include "plumbline/residual/inertial.hpp"
#include "plumbline/residual/zero_motion.hpp"

using namespace plumbline;
using test::allocations_of;

TEMPLATE_TEST_CASE("no_heap: buffer, preintegration, residuals, stationarity, alignment", "", float, double) {
  using S = TestType;
  const test::SimulatedAlignment<S> s(1, 2, {0.01, 0.02, 0.03}, {0.1, 0.1, 0.1});
  testing::Gaussian normal(1);
  const test::RandomMotion motion(normal);
  ImuBuffer<> buffer;
  Preintegration<S, 64> preintegration;
  S sum = 0;
  REQUIRE(allocations_of([&] {
            for (TimeNs t = 0; t <= 1'000'000'000; t += 5'000'000) sum += S(bool(buffer.add(motion.at(t))));
            const ImuCoverage coverage = buffer.for_each_interval(
                2'000'000, 998'000'000, [&](const ImuInterval<double>& d) { preintegration.add(d.cast<S>()); });
            preintegration.reintegrate(Vec<S, 3>::Constant(S(0.01)), Vec<S, 3>::Constant(S(0.1)));
            const NavState<S> x_i, x_j = preintegration.increment().predict(x_i, gravity_in_world<S>());
            auto lin = InertialResidual<S>{preintegration.increment(), gravity_in_world<S>()}.linearize(x_i, x_j);
            lin.whiten(*preintegration.increment().square_root_information());
            const StationarityReport report = stationarity(buffer, 1'000'000'000);
            const auto still = ZeroMotion<S>{}.linearize(x_i.T_world_body, x_j.T_world_body);
            const InertialAlignment<S, 10> a = align_inertial<10>(s.span(), s.T_body_cam.template cast<S>());
            sum += lin.r.sum() + still.r.sum() + a.scale + S(coverage.intervals) + S(report.gyro_spread);
          }) == 0);
  REQUIRE(sum != 0);
  REQUIRE(allocations_of([] { REQUIRE(std::make_unique<int>(3)); }) > 0);  // the watch sees what it should
}
