#include "plumbline/solver/gain_ratio_damping.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("gain_ratio_damping: (15) for gains from small to large, and repeated rejection") {
  const auto mu_after = [](double gain) {
    GainRatioDamping damping{1.0, 16.0};
    damping.accept(gain * 8, 8, 1e-12);
    CHECK(damping.nu == 2);
    return damping.mu;
  };
  CHECK(mu_after(1) == 1.0 / 3);  // 1 - 1 is below a third
  CHECK(mu_after(0.5) == 1);
  CHECK(mu_after(0.75) == 1 - 0.125);
  CHECK(mu_after(0.25) == 1 + 0.125);
  CHECK(mu_after(1e-9) == Approx(2));
  CHECK(mu_after(100) == 1.0 / 3);

  GainRatioDamping damping{1e-3};
  for (const double expected : {2e-3, 8e-3, 64e-3, 1024e-3}) {
    damping.reject();
    CHECK(damping.mu == Approx(expected).epsilon(1e-15));
  }
  damping.accept(1, 1, 0.5);
  CHECK(damping.mu == 0.5);  // not below mu_min
  damping.reject();
  CHECK(damping.mu == 1);
}
