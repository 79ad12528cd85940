#include "arrays.hpp"

#include <cstdint>
#include <limits>

namespace py = pybind11;

namespace {

std::string shape_of(const py::array& array) {
  std::string out;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) out += (i > 0 ? " x " : "") + std::to_string(array.shape(i));
  return array.ndim() == 0 ? "a single number" : out;
}

}  // namespace

template <class Pixel>
cv::Mat image_view(const py::array& array, const std::string& name) {
  if (!py::dtype::of<Pixel>().equal(array.dtype()))
    throw py::type_error(name + " is of " + std::string(py::str(array.dtype())) + ", expected " +
                         std::string(py::str(py::dtype::of<Pixel>())));
  if (array.ndim() != 2 || array.size() == 0 || array.shape(0) > std::numeric_limits<int>::max() ||
      array.shape(1) > std::numeric_limits<int>::max())
    throw py::value_error(name + " is " + shape_of(array) + ", expected height x width");
  constexpr py::ssize_t size = sizeof(Pixel);
  const py::ssize_t least = array.shape(1) * size, step = array.shape(0) > 1 ? array.strides(0) : least;
  const bool are_rows = array.shape(1) == 1 || array.strides(1) == size;
  const bool is_aligned = reinterpret_cast<std::uintptr_t>(array.data()) % size == 0 && step % size == 0;
  if (!are_rows || step < least || !is_aligned)
    throw py::value_error(name + " has strides of " + std::to_string(array.strides(0)) + " and " +
                          std::to_string(array.strides(1)) + " bytes, expected rows of at least " +
                          std::to_string(least) + " bytes with pixels side by side (numpy.ascontiguousarray)");
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), cv::traits::Type<Pixel>::value,
          const_cast<void*>(array.data()), static_cast<std::size_t>(step)};  // it is only read
}
template cv::Mat image_view<std::uint8_t>(const py::array&, const std::string&);
template cv::Mat image_view<std::uint16_t>(const py::array&, const std::string&);

py::array_t<double> rows_of(const py::object& values, const std::string& name, py::ssize_t rows, py::ssize_t columns) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(values);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(name + " is not an array of numbers");
  }
  const bool is_one = rows == 1 && array.ndim() == 1 && array.shape(0) == columns;
  const bool are_many = array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns;
  if (!is_one && !are_many)
    throw py::value_error(name + " is " + shape_of(array) + ", expected " + std::to_string(rows) + " x " +
                          std::to_string(columns));
  return array;
}

py::array_t<std::int64_t> times_of(const py::object& values) {
  auto array = py::array::ensure(values);
  const char kind = array ? array.dtype().kind() : 'O';
  PyErr_Clear();
  if ((kind != 'i' && kind != 'u') || array.ndim() > 1)
    throw py::type_error("t_ns must be a whole number of nanoseconds, or an array of them (int64)");
  return py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array.reshape({array.size()}));
}
