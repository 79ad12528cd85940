#pragma once
/// numpy arrays seen as images, samples and poses, and the other way round.

#include <string>

#include <pybind11/numpy.h>
#include <opencv2/core/mat.hpp>

#include "plumbline/io/trajectory.hpp"

/// The pixels of an array of height x width, without a copy: rows may be padded, pixels of a row are side by side.
/// Throws TypeError or ValueError that names the array, what it is and what is expected.
template <class Pixel>
cv::Mat image_view(const pybind11::array& array, const std::string& name);

/// Rows of `columns` numbers as float64, copied where they are not; of a single sample `rows` is 1. Throws ValueError.
pybind11::array_t<double> rows_of(const pybind11::object& values, const std::string& name, pybind11::ssize_t rows,
                                  pybind11::ssize_t columns);

/// Time stamps in nanoseconds as int64, of one number or a list of them. Throws TypeError of anything but whole
/// numbers: a float64 has no room for them.
pybind11::array_t<std::int64_t> times_of(const pybind11::object& values);

/// A vector or matrix of Eigen as an array of its own, row by row; a vector has one dimension.
template <class Matrix>
pybind11::array_t<double> array_of(const Matrix& matrix) {
  constexpr bool is_vector = Matrix::ColsAtCompileTime == 1;
  pybind11::array_t<double> out(is_vector ? std::vector<pybind11::ssize_t>{matrix.rows()}
                                          : std::vector<pybind11::ssize_t>{matrix.rows(), matrix.cols()});
  double* to = out.mutable_data();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) *to++ = static_cast<double>(matrix(i, j));
  return out;
}
