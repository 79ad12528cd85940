// Nothing in imu/ allocates: neither through Eigen (checked also in release builds) nor through operator new.
namespace {
bool watching = false;
int allocations = 0;
}  // namespace
#define EIGEN_RUNTIME_NO_MALLOC
#define eigen_assert(condition) (static_cast<bool>(condition) ? void() : void(allocations += watching ? 1 : 0))

#include <cstdlib>
#include <memory>
#include <new>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"
#include "plumbline/imu/alignment.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/imu/standstill.hpp"
#include "plumbline/residual/inertial.hpp"
#include "plumbline/residual/zero_motion.hpp"

#pragma GCC diagnostic ignored "-Wmismatched-new-delete"  // inlined, ours looks like malloc to the compiler
void* operator new(std::size_t size) {
  allocations += watching ? 1 : 0;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace plumbline;

namespace {

template <class F>
int allocations_of(F&& f) {
  allocations = 0;
  watching = true;
  Eigen::internal::set_is_malloc_allowed(false);
  f();
  Eigen::internal::set_is_malloc_allowed(true);
  watching = false;
  return allocations;
}

}  // namespace

TEMPLATE_TEST_CASE("no_heap: buffer, preintegration, residuals, standstill, alignment", "", float, double) {
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
            const StandstillReport report = standstill(buffer, 1'000'000'000);
            const auto still = ZeroMotion<S>{}.linearize(x_i.T_world_body, x_j.T_world_body);
            const Alignment<S, 10> a = align<10>(s.span(), s.T_body_cam.template cast<S>());
            sum += lin.r.sum() + still.r.sum() + a.scale + S(coverage.intervals) + S(report.gyro_spread);
          }) == 0);
  REQUIRE(sum != 0);
  REQUIRE(allocations_of([] { REQUIRE(std::make_unique<int>(3)); }) > 0);  // the watch sees what it should
}
