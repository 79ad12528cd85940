#include "plumbline/feature/whitened_rows.hpp"

#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {

static_assert(std::is_same_v<FrameLayout<false>, VisualLayout>);
static_assert(FrameLayout<true>::dim == state::Pose::dim + state::ReadoutTime::dim);
// Where the readout does not count there is no column of it.
static_assert(sizeof(WhitenedRows<float, 1, FrameLayout<false>>) < sizeof(WhitenedRows<float, 1, FrameLayout<true>>));

template <class S, int Rows>
struct Residual {
  Mat<S, Rows, Rows> W = Mat<S, Rows, Rows>::Random();
  Vec<S, Rows> r = Vec<S, Rows>::Random(), J_readout = Vec<S, Rows>::Random();
  Mat<S, Rows, 6> J_pose = Mat<S, Rows, 6>::Random();
};

}  // namespace

TEMPLATE_TEST_CASE_SIG("whitened_rows: residual and Jacobians are multiplied with the whitening", "",
                       ((class S, int Rows), S, Rows), (float, 1), (double, 1), (float, 2), (double, 2)) {
  const Residual<S, Rows> x;
  const auto both = WhitenedRows<S, Rows, FrameLayout<true>>::of(x.W, x.r, x.J_pose, x.J_readout);
  const auto pose = WhitenedRows<S, Rows, FrameLayout<false>>::of(x.W, x.r, x.J_pose, x.J_readout);
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  REQUIRE((both.valid && pose.valid));
  REQUIRE((both.r - x.W * x.r).norm() < tolerance);
  REQUIRE((both.J.template leftCols<6>() - x.W * x.J_pose).norm() < tolerance);
  REQUIRE((both.J.col(6) - x.W * x.J_readout).norm() < tolerance);
  REQUIRE(pose.r == both.r);
  REQUIRE(pose.J == both.J.template leftCols<6>());
  REQUIRE_FALSE(WhitenedRows<S, Rows, FrameLayout<true>>{}.valid);
}
