#pragma once
/// Essential matrices of five pairs of bearings (Nister): at most ten.                      docs/math/geometry.md 6
///
///   f2^T E f1 = 0 five times:   E = x X + y Y + z Z + W                                                       (17)
///   det E = 0,   E E^T E - 1/2 tr(E E^T) E = 0:   ten cubics in x, y, z                                       (18)
/// Gauss-Jordan elimination of their ten monomials of highest order in x, y leaves six rows, of which three pairs, the
/// second times z taken from the first, have the monomials x, y, 1 only, with polynomials in z:
///   B(z) [x y 1]^T = 0,   det B(z) = 0 of degree ten                                                          (19)
/// Planes are no special case. All of it is done in double: the coefficients of det B are differences of large numbers.

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <Eigen/Geometry>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/solver/householder.hpp"
#include "plumbline/solver/real_roots.hpp"

namespace plumbline {

namespace five_point_detail {

/// Polynomials in x, y, z by the exponents of their monomials, in the order of Nister's elimination: the ten that are
/// eliminated, then those of which B(z) is made.
struct Monomial {
  int x, y, z;
};
inline constexpr std::array<Monomial, 20> cubic{
    {{3, 0, 0}, {0, 3, 0}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}, {2, 0, 0}, {0, 2, 1}, {0, 2, 0}, {1, 1, 1}, {1, 1, 0},
     {1, 0, 2}, {1, 0, 1}, {1, 0, 0}, {0, 1, 2}, {0, 1, 1}, {0, 1, 0}, {0, 0, 3}, {0, 0, 2}, {0, 0, 1}, {0, 0, 0}}};
inline constexpr std::array<Monomial, 10> quadratic{
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {1, 0, 0}, {0, 2, 0}, {0, 1, 1}, {0, 1, 0}, {0, 0, 2}, {0, 0, 1}, {0, 0, 0}}};
inline constexpr std::array<Monomial, 4> linear{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

/// Index in C of the product of monomial a of A and monomial b of B.
template <std::size_t NA, std::size_t NB, std::size_t NC>
constexpr std::array<std::array<int, NB>, NA> product_table(const std::array<Monomial, NA>& A,
                                                            const std::array<Monomial, NB>& B,
                                                            const std::array<Monomial, NC>& C) {
  std::array<std::array<int, NB>, NA> table{};
  for (std::size_t a = 0; a < NA; ++a) {
    for (std::size_t b = 0; b < NB; ++b) {
      for (std::size_t c = 0; c < NC; ++c) {
        const bool same = A[a].x + B[b].x == C[c].x && A[a].y + B[b].y == C[c].y && A[a].z + B[b].z == C[c].z;
        if (same) table[a][b] = int(c);
      }
    }
  }
  return table;
}
inline constexpr auto linear_linear = product_table(linear, linear, quadratic);
inline constexpr auto quadratic_linear = product_table(quadratic, linear, cubic);

using Linear = std::array<double, 4>;
using Quadratic = std::array<double, 10>;
using Cubic = std::array<double, 20>;

inline void add_product(Quadratic& out, const Linear& a, const Linear& b, double sign) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) out[std::size_t(linear_linear[i][j])] += sign * a[i] * b[j];
  }
}
inline void add_product(Cubic& out, const Quadratic& a, const Linear& b) {
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t j = 0; j < 4; ++j) out[std::size_t(quadratic_linear[i][j])] += a[i] * b[j];
  }
}

/// The four matrices of (17), row by row, as coefficients of x, y, z, 1. False when the pairs leave more than four.
template <class S>
bool null_space(const std::array<BearingPair<S>, 5>& pairs, std::array<Linear, 9>& E) {
  constexpr int rows = 9, cols = 5 + 9;  // [A^T | I] becomes [R | Q^T], whose last four rows are the null space of A
  std::array<double, rows * cols> M{};
  for (std::size_t k = 0; k < 5; ++k) {
    for (std::size_t i = 0; i < 9; ++i)
      M[k * rows + i] = double(pairs[k].f2[int(i / 3)]) * double(pairs[k].f1[int(i % 3)]);
  }
  for (std::size_t i = 0; i < 9; ++i) M[(5 + i) * rows + i] = 1;
  if (eliminate_leading_columns(M.data(), rows, cols, rows, 5) < 5) return false;
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t k = 0; k < 4; ++k) E[i][k] = M[(5 + i) * rows + 5 + k];
  }
  return true;
}

/// (18): determinant first.
inline std::array<Cubic, 10> constraints(const std::array<Linear, 9>& E) {
  std::array<Cubic, 10> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    Quadratic minor{};
    add_product(minor, E[3 + (k + 1) % 3], E[6 + (k + 2) % 3], 1);
    add_product(minor, E[3 + (k + 2) % 3], E[6 + (k + 1) % 3], -1);
    add_product(out[0], minor, E[k]);
  }
  std::array<std::array<Quadratic, 3>, 3> G{};  // E E^T - 1/2 tr(E E^T) I
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) add_product(G[i][j], E[3 * i + k], E[3 * j + k], 1);
    }
  }
  for (std::size_t m = 0; m < 10; ++m) {
    const double half_trace = (G[0][0][m] + G[1][1][m] + G[2][2][m]) / 2;
    for (std::size_t i = 0; i < 3; ++i) G[i][i][m] -= half_trace;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) add_product(out[1 + 3 * i + j], G[i][k], E[3 * k + j]);
    }
  }
  return out;
}

/// Gauss-Jordan elimination with row pivots; the rows above `first_kept` are not needed afterward.
inline bool eliminate(std::array<Cubic, 10>& M, std::size_t first_kept) {
  for (std::size_t c = 0; c < 10; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < 10; ++r) pivot = std::abs(M[r][c]) > std::abs(M[pivot][c]) ? r : pivot;
    std::swap(M[c], M[pivot]);
    const double scale = 1 / M[c][c];
    if (!std::isfinite(scale)) return false;
    for (std::size_t k = c; k < 20; ++k) M[c][k] *= scale;
    for (std::size_t r = c + 1; r < 10; ++r) {
      const double factor = M[r][c];
      for (std::size_t k = c; k < 20; ++k) M[r][k] -= factor * M[c][k];
    }
  }
  for (std::size_t c = 9; c > first_kept; --c) {
    for (std::size_t r = first_kept; r < c; ++r) {
      const double factor = M[r][c];
      for (std::size_t k = c; k < 20; ++k) M[r][k] -= factor * M[c][k];
    }
  }
  return true;
}

/// Polynomials in z, ascending powers; B(z) has degrees 3, 3, 4 in each row.
template <std::size_t NA, std::size_t NB>
std::array<double, NA + NB - 1> times(const std::array<double, NA>& a, const std::array<double, NB>& b) {
  std::array<double, NA + NB - 1> out{};
  for (std::size_t i = 0; i < NA; ++i) {
    for (std::size_t j = 0; j < NB; ++j) out[i + j] += a[i] * b[j];
  }
  return out;
}
struct RowOfB {
  std::array<double, 4> x{}, y{};
  std::array<double, 5> one{};

  /// a - z b, rows of the eliminated cubics
  RowOfB(const Cubic& a, const Cubic& b) {
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] += a[12 - k], x[k + 1] -= b[12 - k];
      y[k] += a[15 - k], y[k + 1] -= b[15 - k];
    }
    for (std::size_t k = 0; k < 4; ++k) one[k] += a[19 - k], one[k + 1] -= b[19 - k];
  }
  Vec<double, 3> at(double z) const {
    const auto evaluate = [z](const double* c, int degree) {
      double value = c[degree];
      for (int k = degree - 1; k >= 0; --k) value = value * z + c[k];
      return value;
    };
    return {evaluate(x.data(), 3), evaluate(y.data(), 3), evaluate(one.data(), 4)};
  }
};

inline std::array<double, 11> determinant(const std::array<RowOfB, 3>& B) {
  std::array<double, 11> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const RowOfB &a = B[(k + 1) % 3], &b = B[(k + 2) % 3];
    const std::array<double, 7> plus = times(a.x, b.y), minus = times(a.y, b.x);
    std::array<double, 7> minor;
    for (std::size_t i = 0; i < 7; ++i) minor[i] = plus[i] - minus[i];
    const std::array<double, 11> term = times(minor, B[k].one);
    for (std::size_t i = 0; i < 11; ++i) out[i] += term[i];
  }
  return out;
}

}  // namespace five_point_detail

/// With f2^T E f1 = 0 and |E| = 1. Five pairs that are wrong, or of no parallax, have some too.
template <class S>
FixedVector<Mat<S, 3, 3>, 10> five_point(const std::array<BearingPair<S>, 5>& pairs) {
  using namespace five_point_detail;
  FixedVector<Mat<S, 3, 3>, 10> out;
  std::array<Linear, 9> E;
  if (!null_space(pairs, E)) return out;
  std::array<Cubic, 10> M = constraints(E);
  if (!eliminate(M, 4)) return out;
  const std::array<RowOfB, 3> B{RowOfB(M[4], M[5]), RowOfB(M[6], M[7]), RowOfB(M[8], M[9])};
  const std::array<double, 11> p = determinant(B);
  std::array<double, 11> reversed;  // its roots are 1/z: both together are all, and no power overflows
  for (std::size_t k = 0; k < 11; ++k) reversed[k] = p[10 - k];
  const auto add_solution = [&](double z) {
    const Vec<double, 3> r0 = B[0].at(z), r1 = B[1].at(z), r2 = B[2].at(z);
    Vec<double, 3> v = r0.cross(r1);
    for (const Vec<double, 3>& other : {Vec<double, 3>(r1.cross(r2)), Vec<double, 3>(r2.cross(r0))}) {
      if (squared_norm(other) > squared_norm(v)) v = other;
    }
    Mat<double, 3, 3> matrix;
    for (std::size_t i = 0; i < 9; ++i) {
      matrix(int(i / 3), int(i % 3)) = v[0] * E[i][0] + v[1] * E[i][1] + v[2] * (z * E[i][2] + E[i][3]);
    }
    double squared = 0;
    for (int i = 0; i < 9; ++i) squared += matrix.data()[i] * matrix.data()[i];
    const double scale = 1 / std::sqrt(squared);
    if (!std::isfinite(scale)) return;
    Mat<S, 3, 3> result;
    for (int i = 0; i < 9; ++i) result.data()[i] = S(matrix.data()[i] * scale);
    out.push_back(result);
  };
  for (const double z : real_roots<10>(p, -1.0, 1.0)) add_solution(z);
  for (const double inverse : real_roots<10>(reversed, -1.0, 1.0)) {
    if (inverse != 0) add_solution(1 / inverse);
  }
  return out;
}

}  // namespace plumbline
