#pragma once
// Takes down the rows that a kind gives, in double: what it would give to an elimination.

#include <Eigen/Core>

#include "plumbline/core/matrix.hpp"

namespace plumbline::test {

template <class Kind>
struct RecordedRows {
  using S = typename Kind::Scalar;
  Eigen::MatrixXd J_target, J_landmark;  ///< J_target is zero in rows that touch no frame
  Eigen::VectorXd r;
  int slot = -1;  ///< of the last rows that see a frame

  template <int R>
  bool add(int seen_from, const Mat<S, R, 6>& J, const Mat<S, R, Kind::dim>& J_l, const Vec<S, R>& e) {
    slot = seen_from;
    append(J.template cast<double>().eval(), J_l.template cast<double>().eval(), e.template cast<double>().eval());
    return true;
  }
  template <int R>
  bool add(const Mat<S, R, Kind::dim>& J_l, const Vec<S, R>& e) {
    append(Mat<double, R, 6>::Zero().eval(), J_l.template cast<double>().eval(), e.template cast<double>().eval());
    return true;
  }
  int rows() const { return int(r.size()); }

 private:
  void append(const Eigen::MatrixXd& J, const Eigen::MatrixXd& J_l, const Eigen::VectorXd& e) {
    const Eigen::Index n = r.size();
    J_target.conservativeResize(n + e.size(), 6);
    J_landmark.conservativeResize(n + e.size(), J_l.cols());
    r.conservativeResize(n + e.size());
    J_target.bottomRows(e.size()) = J;
    J_landmark.bottomRows(e.size()) = J_l;
    r.tail(e.size()) = e;
  }
};

}  // namespace plumbline::test
