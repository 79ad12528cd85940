// What is a factor, what is none, and the columns of its Jacobian among those of a frame.         docs/math/factors.md
#include "plumbline/factor/factor.hpp"

#include "catch.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// The accelerometer bias, then the velocity: neither all blocks of a frame nor in their order.
struct BiasAndVelocity {
  using Scalar = double;
  using Blocks = Layout<state::AccelBias, state::Velocity>;
  static constexpr int dim = 2;
  static constexpr bool is_marginalized = false;
  struct Linearized {
    bool valid;
    Vec<double, 2> r;
    Mat<double, 2, 6> J_r_x;
  };
  Mat<double, 2, 6> A;

  Linearized linearize(const auto& x, const auto&) const { return {true, residual(x), A}; }
  Vec<double, 2> residual(const auto& x) const {
    return A.leftCols<3>() * x.bias_accel + A.rightCols<3>() * x.v_world_body;
  }
};
static_assert(Factor<BiasAndVelocity> && Factor<AbsolutePosition<float>>);

struct WithoutBlocks {
  using Scalar = double;
  [[maybe_unused]] static constexpr int dim = 1;
  [[maybe_unused]] static constexpr bool is_marginalized = true;
};
struct WithoutResidual : BiasAndVelocity {
  Vec<double, 2> residual(const auto& x) const = delete;
};
struct OfWrongShape : BiasAndVelocity {
  static constexpr int dim = 3;
};
static_assert(!Factor<WithoutBlocks> && !Factor<WithoutResidual> && !Factor<OfWrongShape> && !Factor<int>);

}  // namespace

TEST_CASE("factor: each block of the Jacobian is at the columns of that block in a frame") {
  testing::Gaussian normal(1);
  BiasAndVelocity factor;
  for (int c = 0; c < 6; ++c) factor.A.col(c) = normal.vector<2>();
  const Mat<double, 2, 15> J = by_frame<InertialLayout, BiasAndVelocity>(factor.A);
  const int at_v = InertialLayout::offset<state::Velocity>, at_bias = InertialLayout::offset<state::AccelBias>;
  CHECK((J.middleCols<3>(at_bias) == factor.A.leftCols<3>()));
  CHECK((J.middleCols<3>(at_v) == factor.A.rightCols<3>()));
  CHECK(J.squaredNorm() == Approx(factor.A.squaredNorm()));

  const Mat<double, 3, 6> L = Mat<double, 3, 6>::Random();
  CHECK((by_frame<VisualLayout, AbsolutePosition<double>>(L) == L));
}
