#include "plumbline/solver/landmark_rows.hpp"

#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/solver/relative_equations.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

template <class S, int L = 2, int MaxRows = 24>
using Rows = LandmarkRows<S, L, 6, 4, MaxRows>;

/// Adds R random rows that see `block`.
template <int R, class S, int L, int MaxRows>
bool add(LandmarkRows<S, L, 6, 4, MaxRows>& rows, Random& random, int block) {
  const Mat<S, R, 6> J = random_matrix<S, R, 6>(random);
  const Mat<S, R, L> J_l = random_matrix<S, R, L>(random);
  const Vec<S, R> r = random_matrix<S, R, 1>(random);
  return rows.add(block, J, J_l, r);
}

/// Writes down which sums it is asked for.
struct Asked {
  struct Call {
    int a, j, rows;
    const float *J, *r;
  };
  std::vector<Call> calls;
  template <int R>
  void add(int a, int j, const float* J, const float* r) {
    calls.push_back({a, j, R, J, r});
  }
};

}  // namespace

TEST_CASE("landmark_rows: rows of one call stay together, in groups of up to three") {
  Random random(1);
  Rows<float> rows;
  REQUIRE((add<1>(rows, random, 0) && add<3>(rows, random, 1) && add<7>(rows, random, 2) && add<6>(rows, random, 3)));
  std::vector<int> sizes, blocks;
  int next = 0;
  rows.for_each_group([&]<int R>(const Rows<float>::Group& group) {
    CHECK((group.rows == R && group.first_row == next));
    next += R;
    sizes.push_back(R);
    blocks.push_back(group.block);
  });
  CHECK(next == rows.size());
  CHECK(sizes == std::vector<int>{1, 3, 2, 2, 2, 1, 3, 3});
  CHECK(blocks == std::vector<int>{0, 1, 2, 2, 2, 2, 3, 3});
}

TEMPLATE_TEST_CASE("landmark_rows: refuses what does not fit, and keeps what is there", "", float, double) {
  using S = TestType;
  Random random(2);
  Rows<S, 2, 8> rows;
  CHECK((rows.anchor() == Rows<S>::no_anchor && rows.size() == 0));
  rows.reset(1);
  REQUIRE((add<3>(rows, random, 0) && add<2>(rows, random, 2)));
  const S last = rows.residual(4);
  CHECK_FALSE(add<4>(rows, random, 3));
  const Mat<S, 4, 2> J_l = random_matrix<S, 4, 2>(random);
  CHECK_FALSE(rows.add(J_l, Vec<S, 4>(1, 2, 3, 4)));
  CHECK((rows.size() == 5 && rows.residual(4) == last && rows.anchor() == 1));
  int groups = 0;
  rows.for_each_group([&]<int R>(const auto&) { ++groups; });
  CHECK(groups == 2);
  CHECK(add<3>(rows, random, 3));  // exactly full
  rows.set_residual(7, S(5));
  CHECK(rows.residual(7) == S(5));
  rows.reset();
  CHECK((rows.size() == 0 && rows.anchor() == Rows<S>::no_anchor));
}

TEST_CASE("landmark_rows: sums are those of a block and the anchor, or of the block alone; rows of none take no part") {
  Random random(3);
  for (const int anchor : {2, Rows<float>::no_anchor}) {
    Rows<float> rows;
    rows.reset(anchor);
    const Mat<float, 1, 2> J_l(1, 2);
    REQUIRE((add<2>(rows, random, 0) && rows.add(J_l, Vec<float, 1>(3)) && add<3>(rows, random, 1)));
    Asked asked;
    rows.add_to(asked);
    REQUIRE(asked.calls.size() == 2);
    CHECK((asked.calls[0].j == 0 && asked.calls[0].rows == 2 && asked.calls[1].j == 1 && asked.calls[1].rows == 3));
    for (const Asked::Call& call : asked.calls) CHECK(call.a == (anchor == 2 ? 2 : call.j));
    CHECK(*asked.calls[1].r == rows.residual(3));
  }
}

TEST_CASE("landmark_rows: the reduced rows are orthogonal to the landmark, and lose nothing else") {
  constexpr int stride = 7, columns = 2 + 4 * stride + 1;
  Random random(4);
  for (const int anchor : {3, Rows<double>::no_anchor}) {
    Rows<double> rows;
    rows.reset(anchor);
    RelativeEquations<double, 6, 4> pairs;
    for (int j = 0; j < 3; ++j) pairs.set_transport(3, j, random_matrix<double, 6, 6>(random));
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(9, columns);
    for (int j = 0; j < 3; ++j) {
      const Mat<double, 3, 6> J = random_matrix<double, 3, 6>(random);
      const Mat<double, 3, 2> J_l = random_matrix<double, 3, 2>(random);
      const Vec<double, 3> r = random_matrix<double, 3, 1>(random);
      REQUIRE(rows.add(j, J, J_l, r));
      all.block<3, 2>(3 * j, 0) = J_l;
      all.block<3, 6>(3 * j, 2 + stride * j) = J;
      if (anchor == 3) all.block<3, 6>(3 * j, 2 + stride * 3) = -J * pairs.transport(3, j);
      all.block<3, 1>(3 * j, columns - 1) = r;
    }
    all.col(2 + 6).setConstant(0.5);  // one that no block has
    Eigen::MatrixXd work = Eigen::MatrixXd::Constant(12, columns, std::numeric_limits<double>::quiet_NaN());
    const auto write_more = [&] { work.col(2 + 6).head(9).setConstant(0.5); };
    REQUIRE(rows.reduced(work, pairs, stride, write_more) == 2);
    CHECK(work.block(2, 0, 7, 2).isZero(0));
    const Eigen::MatrixXd done = work.topRightCorner(9, columns - 2), before = all.rightCols(columns - 2);
    CHECK((done.transpose() * done - before.transpose() * before).norm() < 1e-12);  // a rotation of all rows
  }
}
