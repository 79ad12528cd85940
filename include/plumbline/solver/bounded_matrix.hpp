#pragma once
/// A matrix of at most MaxRows x MaxCols inside the object: no heap, and not subject to the 128 KiB to which Eigen
/// limits its own fixed-size objects (EIGEN_STACK_ALLOCATION_LIMIT). It is an Eigen expression like any other. Its
/// values are undefined after `resize`.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <new>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class S, int MaxRows, int MaxCols>
class BoundedMatrix : public Eigen::Map<Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, MaxRows, MaxCols>> {
 public:
  using View = Eigen::Map<Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, MaxRows, MaxCols>>;

  BoundedMatrix() : View(nullptr, 0, 0) {}
  BoundedMatrix(const BoundedMatrix& other) : View(nullptr, 0, 0) { *this = other; }
  BoundedMatrix& operator=(const BoundedMatrix& other) {
    if (this == &other) return *this;
    resize(int(other.rows()), int(other.cols()));
    std::copy_n(other.data(), other.size(), this->data());
    return *this;
  }
  template <class Derived>
  BoundedMatrix& operator=(const Eigen::MatrixBase<Derived>& other) {
    resize(int(other.rows()), int(other.cols()));
    View::operator=(other);
    return *this;
  }

  void resize(int rows, int cols) {
    PLUMBLINE_ASSERT(rows >= 0 && rows <= MaxRows && cols >= 0 && cols <= MaxCols);
    new (static_cast<View*>(this)) View(values_.data(), rows, cols);  // Eigen's way to move a Map
  }

 private:
  std::array<S, std::size_t(MaxRows) * MaxCols> values_;
};

template <class S, int MaxRows, int MaxCols>
void set_zero(BoundedMatrix<S, MaxRows, MaxCols>& A) {
  std::fill_n(A.data(), A.size(), S(0));
}

}  // namespace plumbline
