// The store of the factors of frames: what it gives, what it has room for, and that none of them is nothing.
//                                                                                              docs/math/factors.md
#include "plumbline/factor/frame_factors.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 4;

/// The height alone, and nothing of it in the prior.
template <class S>
struct Height {
  using Scalar = S;
  using Blocks = Layout<state::Pose>;
  static constexpr int dim = 1;
  static constexpr bool is_marginalized = false;
  struct Linearized {
    bool valid;
    Vec<S, 1> r;
    Mat<S, 1, 6> J_r_x;
  };
  S z = S(0);

  Linearized linearize(const auto& x, const auto& x0) const {
    Linearized out{z < S(100), residual(x), {}};
    set_zero(out.J_r_x);
    for (int c = 0; c < 3; ++c) out.J_r_x(0, 3 + c) = x0.T_world_body.R()(2, c);
    return out;
  }
  Vec<S, 1> residual(const auto& x) const { return Vec<S, 1>(x.T_world_body.p().z() - z); }
};

using One = FrameFactors<AbsolutePosition<double>, slots>;
using Several = FrameFactorsOf<double, slots, AbsolutePosition, Height>;
using None = FrameFactorsOf<double, slots>;

static_assert(std::is_same_v<None, NoFrameFactors> && std::is_empty_v<None>);
static_assert(Several::takes<Height<double>> && !Several::takes<Height<float>> && !None::takes<Height<double>>);
struct Backend {
  int window;
  [[no_unique_address]] None factors;
};
static_assert(sizeof(Backend) == sizeof(int));
static_assert(std::is_trivially_copyable_v<AbsolutePosition<float>> || sizeof(One) < 4096);

template <class Layout>
FrameWindow<double, Layout, slots> window_of(int frames) {
  testing::Gaussian normal(5);
  FrameWindow<double, Layout, slots> window;
  for (int k = 0; k < frames; ++k) {
    FrameValue<double, Layout> x{};
    x.T_world_body = SE3<double>(SO3<double>::exp(normal.vector<3>()), normal.vector<3>());
    window.insert(k, x);
  }
  return window;
}
AbsolutePosition<double> at(double x) { return {{x, 0, 0}, 2 * Mat<double, 3, 3>::Identity(), {0.1, 0.2, 0.3}}; }

template <class Factors, class Window>
int rows(const Factors& factors, const Window& window, int slot) {
  int n = 0;
  factors.for_each_row(window, slot, [&](int, const auto& J, const auto& r) {
    static_assert(std::remove_cvref_t<decltype(J)>::ColsAtCompileTime == Window::Layout::dim);
    n += int(r.size());
  });
  return n;
}

}  // namespace

TEST_CASE("frame_factors: rows and cost are those of the frame that a factor is attached to") {
  auto window = window_of<InertialLayout>(3);
  window.state(1).fix_first_estimates();
  Vec<double, 15> step = Vec<double, 15>::Constant(0.1);
  window.state(1).add(step);
  One factors;
  REQUIRE(factors.insert(1, at(1)));
  REQUIRE(factors.insert(2, at(2)));
  double cost = 0;
  int seen = 0;
  factors.for_each_row(window, -1, [&](int slot, const auto& J, const auto& r) {
    const auto& state = window[slot].state;
    const auto alone = at(slot).linearize(state.value(), state.first_estimate());
    CHECK(r == alone.r);
    CHECK((J.template leftCols<6>() == alone.J_r_x));
    CHECK(J.template rightCols<9>().norm() == 0);
    cost += r.squaredNorm() / 2;
    ++seen;
  });
  CHECK(seen == 2);
  CHECK(factors.cost(window) == Approx(cost));
  CHECK(rows(factors, window, 1) == 3);
  CHECK(rows(factors, window, 0) == 0);
}

TEST_CASE("frame_factors: a frame may have several, and takes them with it") {
  const auto window = window_of<VisualLayout>(3);
  One factors;
  for (const int slot : {1, 0, 1, 2}) REQUIRE(factors.insert(slot, at(slot)));
  CHECK(!factors.insert(2, at(0)));  // as many as slots
  CHECK(factors.size() == slots);
  CHECK(rows(factors, window, 1) == 6);
  factors.remove(1);
  CHECK(factors.size() == 2);
  CHECK(rows(factors, window, 1) == 0);
  CHECK(rows(factors, window, -1) == 6);
  CHECK(rows(factors, window, 0) == 3);
  CHECK(factors.insert(1, at(7)));
  factors.clear();
  CHECK(factors.size() == 0);
  CHECK(factors.cost(window) == 0);
}

TEST_CASE("frame_factors: of several types, and which of them are marginalized") {
  const auto window = window_of<VisualLayout>(2);
  Several factors;
  REQUIRE(factors.insert(0, at(0)));
  REQUIRE(factors.insert(0, Height<double>{1}));
  REQUIRE(factors.insert(1, Height<double>{2}));
  CHECK(rows(factors, window, 0) == 4);
  CHECK(rows(factors, window, -1) == 5);
  int marginalized = 0;
  factors.for_each_marginalized_row(window, 0, [&](int, const auto&, const auto& r) { marginalized += int(r.size()); });
  CHECK(marginalized == 3);
  const double z0 = window.T_world_body(0).p().z() - 1, z1 = window.T_world_body(1).p().z() - 2;
  const auto position = at(0).residual(window[0].state.value());
  CHECK(factors.cost(window) == Approx((position.squaredNorm() + z0 * z0 + z1 * z1) / 2));
  factors.remove(0);
  CHECK(rows(factors, window, -1) == 1);
  factors.clear();
  CHECK(rows(factors, window, -1) == 0);
}

TEST_CASE("frame_factors: rows that are not valid are left out") {
  const auto window = window_of<VisualLayout>(1);
  FrameFactors<Height<double>, slots> factors;
  REQUIRE(factors.insert(0, {200}));
  CHECK(rows(factors, window, -1) == 0);
}
