// The increments between the frames of a window: their rows, their cost, and when the samples are integrated again.
//                                                                                docs/math/inertial_window.md
#include "plumbline/propagation/imu_factors.hpp"

#include <algorithm>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 4, dim = InertialLayout::dim;
constexpr TimeNs interval_ns = 200'000'000;

template <class S>
using Window = FrameWindow<S, InertialLayout, slots>;

/// IMU samples of a random motion; the same for both scalars.
template <class S>
Preintegration<S> samples(std::uint64_t seed, int k, const NavState<double>& x) {
  testing::Gaussian noise(seed);
  const test::RandomMotion motion(noise);
  Preintegration<S> out(ImuNoise{}, x.bias_gyro.cast<S>(), x.bias_accel.cast<S>());
  test::for_each_interval(motion, k * interval_ns, (k + 1) * interval_ns, 40,
                          [&](const ImuInterval<double>& interval) { out.add(interval.cast<S>()); });
  return out;
}

/// Three frames one after the other, each where the increment before it ends, up to `error`.
template <class S>
struct Chain {
  ImuFactorOptions options;
  std::unique_ptr<ImuFactors<S, slots>> factors = std::make_unique<ImuFactors<S, slots>>(options);
  Window<S> window;
  std::vector<int> slot;
  std::vector<ImuFactor<S>> given;

  explicit Chain(std::uint64_t seed, double error = 0, bool is_stationary = false, double bias_error = 0) {
    testing::Gaussian noise(seed + 1000);
    NavState<double> x = test::random_state(noise);
    for (int k = 0; k < 3; ++k) {
      ImuFactor<S> factor;
      if (k > 0) {
        const Preintegration<double> increment = samples<double>(seed, k, x);
        const Preintegration<S> cast = samples<S>(seed, k, x);
        factor = {slot.back(), cast.intervals(), cast.noise(), is_stationary};
        Vec<double, dim> off = error * noise.vector<dim>();
        off.tail<6>() *= bias_error;
        x = plus(increment.increment().predict(x, gravity_in_world<double>()), off);
      }
      slot.push_back(window.insert(k, x.cast<S>()));
      factors->insert(slot.back(), x.cast<S>(), factor);
      given.push_back(factor);
    }
    factors->activate();
  }
  /// Steps of all frames, as a solver makes them.
  void move(testing::Gaussian& noise, double size) {
    for (const int k : slot) window.state(k).add(Vec<S, dim>((size * noise.vector<dim>()).template cast<S>()));
  }
};

struct Rows {
  int i, j, rows;
  double cost;
};
template <class S>
std::vector<Rows> rows_of(const Chain<S>& chain, int touching = -1) {
  std::vector<Rows> out;
  chain.factors->for_each_row(chain.window, touching,
                              [&](int i, const auto&, int j, const auto&, const auto&, const auto& r) {
                                out.push_back({i, j, int(r.size()), double(r.squaredNorm()) / 2});
                              });
  return out;
}
double cost_of(const std::vector<Rows>& rows) {
  double sum = 0;
  for (const Rows& row : rows) sum += row.cost;
  return sum;
}

/// Compares the rows' Jacobians with numeric ones by the corrections e of both frames, taken at the first estimates.
template <class S>
void require_jacobians(bool is_stationary, double tolerance) {
  for (std::uint64_t seed = 1; seed < 8; ++seed) {
    const Chain<S> chain(seed, 0.05, is_stationary, 1);
    const Chain<double> exact(seed, 0.05, is_stationary, 1);
    std::vector<int> seen;
    chain.factors->for_each_row(
        chain.window, -1, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto& r) {
          constexpr int rows = std::remove_cvref_t<decltype(r)>::RowsAtCompileTime;
          seen.push_back(rows);
          // The same rows in double, with one of the frames somewhere else.
          const auto residual = [&](int moved, const NavState<double>& x) {
            Window<double> window = exact.window;
            window.state(moved) = typename Window<double>::State(x);
            Vec<double, rows> out;
            out.setConstant(std::nan(""));
            exact.factors->for_each_row(
                window, -1, [&](int a, const auto&, int b, const auto&, const auto&, const auto& at_x) {
                  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(at_x)>, Vec<double, rows>>) {
                    if (a == i && b == j) out = at_x;
                  }
                });
            return out;
          };
          const auto error = [&](const auto& J, int moved) {
            return testing::jacobian_error(
                J, [&](const NavState<double>& x) { return residual(moved, x); },
                exact.window[moved].state.first_estimate());
          };
          CAPTURE(seed, i, j, rows);
          CHECK(error(J_i, i) < tolerance);
          CHECK(error(J_j, j) < tolerance);
          CHECK((r.template cast<double>() - residual(i, exact.window[i].state.value())).norm() <
                100 * tolerance * (1 + double(r.norm())));
        });
    CHECK(seen.size() == (is_stationary ? 4u : 2u));
  }
}

}  // namespace

TEST_CASE("imu_factors: rows have the Jacobians of their residuals", "") {
  require_jacobians<double>(false, 1e-6);
  require_jacobians<double>(true, 1e-6);
}
TEST_CASE("imu_factors: the same in float") { require_jacobians<float>(true, 2e-3); }

TEST_CASE("imu_factors: Jacobians stay at the first estimates, residuals do not") {
  Chain<double> chain(3, 0.05, true, 1);
  for (const int k : chain.slot) chain.window.state(k).fix_first_estimates();
  std::vector<Mat<double, dim, dim>> before;
  const auto collect = [&](std::vector<Mat<double, dim, dim>>& out) {
    out.clear();
    chain.factors->for_each_row(chain.window, -1,
                                [&](int, const auto& J_i, int, const auto& J_j, const auto&, const auto&) {
                                  Mat<double, dim, dim> both = Mat<double, dim, dim>::Zero();
                                  both.topRows(J_i.rows()) = J_i;
                                  out.push_back(both);
                                  both.topRows(J_j.rows()) = J_j;
                                  out.push_back(both);
                                });
  };
  collect(before);
  const double cost = chain.factors->cost(chain.window);
  testing::Gaussian noise(4);
  chain.move(noise, 0.02);
  std::vector<Mat<double, dim, dim>> after;
  collect(after);
  REQUIRE(before.size() == after.size());
  for (std::size_t k = 0; k < before.size(); ++k) CHECK(before[k] == after[k]);
  CHECK(chain.factors->cost(chain.window) != Approx(cost));
}

TEMPLATE_TEST_CASE("imu_factors: the cost is that of the rows", "", float, double) {
  const double tolerance = std::is_same_v<TestType, float> ? 1e-3 : 1e-9;
  for (const bool is_stationary : {false, true}) {
    Chain<TestType> chain(5, 0.02, is_stationary, 0.1);
    testing::Gaussian noise(6);
    for (int n = 0; n < 5; ++n) {
      const std::vector<Rows> rows = rows_of(chain);
      CHECK(rows.size() == (is_stationary ? 4u : 2u));
      CHECK(cost_of(rows) > 0);
      CHECK(double(chain.factors->cost(chain.window)) == Approx(cost_of(rows)).epsilon(tolerance));
      chain.move(noise, 0.01);
    }
  }
}

TEST_CASE("imu_factors: zero cost without errors, and linearized rows predict its growth") {
  Chain<double> chain(7);
  CHECK(chain.factors->cost(chain.window) < 1e-15);
  CHECK(chain.factors->disagreement(chain.window) < 1e-15);
  // 1/2 |r + J e|^2 for small e.
  testing::Gaussian noise(8);
  Vec<double, slots* dim> e = Vec<double, slots * dim>::Zero();
  for (const int k : chain.slot) e.segment<dim>(k * dim) = 1e-6 * noise.vector<dim>();
  double linear = 0;
  chain.factors->for_each_row(
      chain.window, -1, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto& r) {
        linear += (r + J_i * e.segment<dim>(i * dim) + J_j * e.segment<dim>(j * dim)).squaredNorm() / 2;
      });
  for (const int k : chain.slot) chain.window.state(k).add(e.segment<dim>(k * dim));
  CHECK(chain.factors->cost(chain.window) == Approx(linear).epsilon(1e-3));
}

TEST_CASE("imu_factors: rows of a stationary factor are those of ZeroMotion and ZeroVelocity, in their sigmas") {
  const Chain<double> chain(9, 0.02, true, 1);
  const ImuFactorOptions& options = chain.options;
  int factors = 0;
  chain.factors->for_each_row(
      chain.window, -1, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto& r) {
        constexpr int rows = std::remove_cvref_t<decltype(r)>::RowsAtCompileTime;
        if constexpr (rows == ZeroMotion<double>::dim + ZeroVelocity<double>::dim) {
          ++factors;
          const NavState<double> x_i = chain.window[i].state.value(), x_j = chain.window[j].state.value();
          const NavState<double> x_i0 = chain.window[i].state.first_estimate(),
                                 x_j0 = chain.window[j].state.first_estimate();
          const auto motion =
              ZeroMotion<double>{}.linearize(x_i.T_world_body, x_j.T_world_body, x_i0.T_world_body, x_j0.T_world_body);
          const auto velocity = ZeroVelocity<double>{}.linearize(x_j.v_world_body);
          Vec<double, rows> w;
          w << Vec<double, 3>::Constant(1 / options.stationary_rotation_sigma),
              Vec<double, 3>::Constant(1 / options.stationary_position_sigma),
              Vec<double, 3>::Constant(1 / options.zero_velocity_sigma);
          Mat<double, rows, dim> expected_i = Mat<double, rows, dim>::Zero(), expected_j = expected_i;
          expected_i.template topLeftCorner<6, 6>() = motion.J_r_i;
          expected_j.template topLeftCorner<6, 6>() = motion.J_r_j;
          expected_j.template block<3, 3>(6, InertialLayout::offset<state::Velocity>) = velocity.J_r_v;
          Vec<double, rows> expected;
          expected << motion.r, velocity.r;
          CHECK((J_i - w.asDiagonal() * expected_i).norm() < 1e-9 * J_i.norm());
          CHECK((J_j - w.asDiagonal() * expected_j).norm() < 1e-9 * J_j.norm());
          CHECK((r - w.cwiseProduct(expected)).norm() < 1e-9 * r.norm());
        }
      });
  CHECK(factors == 2);
}

TEMPLATE_TEST_CASE("imu_factors: a bias jump inflates the covariance of the factor", "", float, double) {
  using S = TestType;
  for (const bool jumped : {false, true}) {
    Chain<S> chain(4);
    const int j = chain.slot[2];
    ImuFactor<S> factor = chain.given[2];
    factor.jumped = jumped;
    chain.factors->insert(j, chain.window[j].state.value(), factor);
    const double before = chain.factors->cost(chain.window);
    Vec<S, dim> d = Vec<S, dim>::Zero();
    d[9] = S(0.1);  // the gyroscope's bias of the last frame
    chain.window.state(j).add(d);
    const double cost = chain.factors->cost(chain.window) - before;
    if (jumped)
      CHECK(cost < 1);  // half a sigma
    else
      CHECK(cost > 1e3);
  }
}

TEMPLATE_TEST_CASE("imu_factors: a suspect accelerometer inflates the previous factors, too", "", float, double) {
  using S = TestType;
  for (const bool suspect : {false, true}) {
    Chain<S> chain(5);
    const int j = chain.slot[2];
    ImuFactor<S> factor = chain.given[2];
    factor.is_accel_suspect = suspect;
    chain.factors->insert(j, chain.window[j].state.value(), factor);
    const double before = chain.factors->cost(chain.window);
    Vec<S, dim> d = Vec<S, dim>::Zero();
    d[6] = S(0.5);  // the velocity of the first frame
    chain.window.state(chain.slot[0]).add(d);
    const double cost = chain.factors->cost(chain.window) - before;
    if (suspect)
      CHECK(cost < 0.01);
    else
      CHECK(cost > 1e3);
  }
}

TEST_CASE("imu_factors: used once they are activated") {
  Chain<double> chain(10, 0.05);
  REQUIRE(chain.factors->cost(chain.window) > 0);
  chain.factors->deactivate();
  CHECK_FALSE(chain.factors->active());
  CHECK(rows_of(chain).empty());
  CHECK(chain.factors->cost(chain.window) == 0);
  chain.factors->activate();
  CHECK(rows_of(chain).size() == 2);
}

TEST_CASE("imu_factors: those of one frame are the ones that go with it") {
  const Chain<double> chain(11, 0.05);
  CHECK(rows_of(chain, chain.slot[0]).size() == 1);
  CHECK(rows_of(chain, chain.slot[1]).size() == 2);
  CHECK(rows_of(chain, chain.slot[2]).size() == 1);
  CHECK(rows_of(chain, chain.slot[2])[0].i == chain.slot[1]);

  Chain<double> cut(11, 0.05);
  cut.factors->remove(cut.slot[0]);
  cut.window.remove(cut.slot[0]);
  CHECK(rows_of(cut).size() == 1);
  CHECK(cut.factors->previous(cut.slot[1]) == -1);
  CHECK(cut.factors->previous(cut.slot[2]) == cut.slot[1]);
}

TEMPLATE_TEST_CASE("imu_factors: the inconsistency is in units of the sample noise", "", float, double) {
  using S = TestType;
  CHECK(Chain<S>(12).factors->disagreement(Window<S>{}) == 0);  // no increments
  // One of nine numbers is off, by known sigmas.
  Chain<S> chain(12);
  const int last = chain.slot[2];
  const double base = double(chain.factors->disagreement(chain.window));
  CHECK(base < 0.05);
  Vec<S, dim> d = Vec<S, dim>::Zero();
  const Mat<S, dim, dim> L = *chain.factors->increment(last).square_root_information();
  const Vec<S, 3> off(S(0.02), S(-0.01), S(0.03));  // of the velocity
  const Mat<S, 3, 3> R = chain.window[chain.slot[1]].state.value().T_world_body.R();
  constexpr int at_v = InertialLayout::offset<state::Velocity>;
  for (int k = 0; k < 3; ++k) d[at_v + k] = (R * off)[k];
  chain.window.state(last).add(d);
  Vec<S, dim> r = Vec<S, dim>::Zero();
  for (int k = 0; k < 3; ++k) r[at_v + k] = off[k];
  const double expected = double((L * r).squaredNorm()) / (9 * 2);  // two increments
  CHECK(double(chain.factors->disagreement(chain.window)) == Approx(expected).epsilon(0.05));
}

TEMPLATE_TEST_CASE("imu_factors: velocities are initialized from positions", "", float, double) {
  using S = TestType;
  Chain<S> chain(13);
  const double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-9;
  std::vector<NavState<S>> truth;
  for (const int k : chain.slot) truth.push_back(chain.window[k].state.value());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    NavState<S> x = truth[k];
    x.v_world_body.setConstant(S(7));
    chain.window.state(chain.slot[k]) = typename Window<S>::State(x);
  }
  chain.factors->initialize_velocities(chain.window);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const NavState<S> x = chain.window[chain.slot[k]].state.value();
    CHECK(double((x.v_world_body - truth[k].v_world_body).norm()) < tolerance);
    CHECK(double(minus(x.T_world_body, truth[k].T_world_body).norm()) == 0);
    // A guess is a first estimate.
    CHECK(chain.window[chain.slot[k]].state.first_estimate().v_world_body == x.v_world_body);
  }
}

TEMPLATE_TEST_CASE("imu_factors: samples are integrated again where the biases have changed", "", float, double) {
  using S = TestType;
  Chain<S> chain(14);
  const int first = chain.slot[0], second = chain.slot[1], third = chain.slot[2];
  const Vec<S, 3> before = chain.factors->increment(second).bias_gyro;
  Vec<S, dim> d = Vec<S, dim>::Zero();
  d[InertialLayout::offset<state::GyroBias>] = S(1e-4);  // near
  chain.window.state(first).add(d);
  chain.factors->reintegrate(chain.window);
  CHECK(chain.factors->increment(second).bias_gyro == before);
  d[InertialLayout::offset<state::GyroBias>] = S(0.2);
  chain.window.state(first).add(d);
  chain.factors->reintegrate(chain.window);
  CHECK(chain.factors->increment(second).bias_gyro == chain.window[first].state.value().bias_gyro);
  CHECK(chain.factors->increment(third).bias_gyro == chain.window[second].state.value().bias_gyro);
  CHECK(chain.factors->increment(second).bias_gyro != before);
}

TEST_CASE("imu_factors: an increment without samples has no weight and no row") {
  Chain<double> chain(15);
  chain.factors->insert(chain.slot[2], chain.window[chain.slot[2]].state.value(), {.previous = chain.slot[1]});
  CHECK(rows_of(chain).size() == 1);
  CHECK(std::isfinite(chain.factors->cost(chain.window)));
  CHECK(std::isfinite(chain.factors->disagreement(chain.window)));
}

namespace {

/// As `Chain`, each frame cut by another time offset; the window has that of the last one, and `d` more.
template <class S>
struct ShiftedChain : Chain<S> {
  using Chain<S>::factors, Chain<S>::window, Chain<S>::slot, Chain<S>::given;
  static constexpr double cuts_s[] = {-0.02, 0.015, 0.03};

  explicit ShiftedChain(std::uint64_t seed, double error = 0.05) : Chain<S>(seed, error, false, 1) {
    testing::Gaussian noise(seed + 2000);
    std::array<SampleBoundary<S>, 3> cuts;
    for (std::size_t k = 0; k < 3; ++k) cuts[k] = {cuts_s[k], noise.vector<3>().template cast<S>()};
    for (std::size_t k = 1; k < 3; ++k) {
      ImuFactor<S> factor = given[k];
      factor.begin = cuts[k - 1];
      factor.end = cuts[k];
      factors->insert(slot[k], window[slot[k]].state.value(), factor);
    }
    window.estimate_time_offset(cuts_s[2]);
  }
  /// take(i, J_i, j, J_j, J_offset, r) of the increments.
  void for_each_increment(const Window<S>& at, auto&& take) const {
    factors->for_each_row(at, -1,
                          [&](int i, const auto& J_i, int j, const auto& J_j, const auto& J_offset, const auto& r) {
                            if constexpr (std::is_same_v<std::remove_cvref_t<decltype(r)>, Vec<S, 15>>)
                              take(i, J_i, j, J_j, J_offset, r);
                          });
  }
  /// All their rows, with another time offset.
  std::vector<Vec<double, 15>> residuals(double d) const {
    Window<S> moved = window;
    moved.estimate_time_offset(cuts_s[2] + d);
    std::vector<Vec<double, 15>> out;
    for_each_increment(moved, [&](int, const auto&, int, const auto&, const auto&, const auto& r) {
      out.push_back(r.template cast<double>());
    });
    return out;
  }
};

template <class S>
void require_offset_jacobian(double tolerance) {
  for (std::uint64_t seed = 1; seed < 8; ++seed) {
    const ShiftedChain<S> chain(seed);
    const ShiftedChain<double> exact(seed);
    const double step = 1e-5;
    const auto before = exact.residuals(-step), after = exact.residuals(step);
    std::size_t n = 0;
    chain.for_each_increment(chain.window, [&](int, const auto&, int, const auto&, const auto& J, const auto&) {
      const Vec<double, 15> numeric = (after[n] - before[n]) / (2 * step);
      CAPTURE(seed, n);
      CHECK((J.template cast<double>() - numeric).norm() < tolerance * numeric.norm());
      ++n;
    });
    REQUIRE(n == 2);
  }
}

}  // namespace

TEST_CASE("imu_factors: rows have the Jacobian by the time offset") { require_offset_jacobian<double>(1e-6); }
TEST_CASE("imu_factors: the Jacobian by the time offset in float") { require_offset_jacobian<float>(2e-3); }

TEST_CASE("imu_factors: a frame with another sample boundary has the Jacobians of its residuals") {
  for (std::uint64_t seed = 1; seed < 8; ++seed) {
    const ShiftedChain<double> chain(seed);
    std::size_t n = 0;
    chain.for_each_increment(
        chain.window, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto&) {
          const auto error = [&](const auto& J, int moved) {
            const auto residual = [&](const NavState<double>& x) {
              ShiftedChain<double> other(seed);
              other.window.state(moved) = Window<double>::State(x);
              return other.residuals(0)[n];
            };
            return testing::jacobian_error(J, residual, chain.window[moved].state.first_estimate());
          };
          CAPTURE(seed, i, j);
          CHECK(error(Mat<double, 15, 15>(J_i), i) < 1e-6);
          CHECK(error(Mat<double, 15, 15>(J_j), j) < 1e-6);
          ++n;
        });
    REQUIRE(n == 2);
  }
}

TEST_CASE("imu_factors: cost and inconsistency are those of the rows for any time offset") {
  const ShiftedChain<double> chain(5);
  CHECK(chain.factors->cost(chain.window) == Approx(cost_of(rows_of<double>(chain))));
  CHECK(chain.factors->disagreement(chain.window) > 0);
}
