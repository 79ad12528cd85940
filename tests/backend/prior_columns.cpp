#include "plumbline/backend/prior_columns.hpp"

#include "catch.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

namespace {
using Window = FrameWindow<double, InertialLayout, 3>;
using Columns = PriorColumns<Window, true>;
}  // namespace

TEST_CASE("prior_columns: frames by slot, extrinsics, time offset and readout time, without a gap") {
  STATIC_REQUIRE(Columns::at_extrinsics == 3 * 15);
  STATIC_REQUIRE(Columns::at_time_offset == Columns::at_extrinsics + 6);
  STATIC_REQUIRE(Columns::at_readout == Columns::at_time_offset + 1);
  STATIC_REQUIRE(Columns::dim == Columns::at_readout + 1);
  STATIC_REQUIRE(PriorColumns<Window>::dim == Columns::at_readout);
  using Visual = PriorColumns<FrameWindow<double, VisualLayout, 3>>;
  STATIC_REQUIRE((Visual::dim == 3 * 6 && Visual::at_readout == Visual::dim));
}

TEST_CASE("prior_columns: corrections are those since the first estimates; those of free slots are zero") {
  Window window;
  window.estimate_extrinsics(SE3<double>());
  window.estimate_time_offset(0.02);
  const int a = window.insert(0, {}), b = window.insert(1, {});
  for (const int slot : {a, b}) window.state(slot).fix_first_estimates();
  Vec<double, 3 * 15 + 7> step = 1e-3 * Vec<double, 3 * 15 + 7>::Random();
  window.move(step);
  const Columns::Vector e = Columns::corrections(window, 0.03);
  for (const int slot : {a, b}) CHECK((e.segment<15>(slot * 15) - step.segment<15>(slot * 15)).norm() < 1e-6);
  CHECK(e.segment<15>((3 - a - b) * 15).isZero(0));
  CHECK((e.segment<7>(Columns::at_extrinsics) - step.tail<7>()).norm() < 1e-6);
  CHECK(e[Columns::at_readout] == 0.03);
}

TEST_CASE("prior_columns: extrinsics move all poses together") {
  constexpr int first = 2;  // columns of a landmark before those of the window
  Eigen::MatrixXd rows = Eigen::MatrixXd::Random(2, first + Columns::dim);
  const Eigen::MatrixXd before = rows;
  const Columns::Adjoint E = Columns::Adjoint::Random();
  Columns::move_with_extrinsics(rows, 1, first, E);
  Eigen::RowVectorXd together = Eigen::RowVectorXd::Zero(6);
  for (int slot = 0; slot < 3; ++slot) together += before.block<1, 6>(1, first + slot * 15);
  Eigen::MatrixXd expected = before;
  expected.block<1, 6>(1, first + Columns::at_extrinsics) += together * E;
  CHECK((rows - expected).norm() < 1e-12);
}
