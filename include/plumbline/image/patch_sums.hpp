#pragma once
/// Sums over the samples of a patch, in packets of the processor.
///
/// They are Eigen's sum, dot and squaredNorm to the last bit, but for a compiler a few dozen functions instead of two
/// thousand: packets are added by halves where the sum is short, and by two running sums elsewhere.

#include <Eigen/Core>
#include <type_traits>

#include "plumbline/core/matrix.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wignored-attributes"  // GCC warns about every template argument __m128

namespace plumbline {

namespace detail {
using Packet = Eigen::internal::packet_traits<float>::type;
constexpr int patch_packet = Eigen::internal::packet_traits<float>::size;

template <class T>
EIGEN_ALWAYS_INLINE T load(const float* x) {
  if constexpr (std::is_same_v<T, float>) {
    return *x;
  } else {
    return Eigen::internal::ploadu<T>(x);
  }
}

// What is summed: its terms from i on, one or a packet of them. `cost` counts what one of them takes.
struct Samples {
  static constexpr int cost = 1;
  const float* a;
  template <class T>
  EIGEN_ALWAYS_INLINE T at(int i) const {
    return load<T>(a + i);
  }
};
struct Products {
  static constexpr int cost = 3;
  const float *a, *b;
  template <class T>
  EIGEN_ALWAYS_INLINE T at(int i) const {
    return Eigen::internal::pmul(load<T>(a + i), load<T>(b + i));
  }
};
struct Squares {
  static constexpr int cost = 2;
  const float* a;
  template <class T>
  EIGEN_ALWAYS_INLINE T at(int i) const {
    const T x = load<T>(a + i);
    return Eigen::internal::pmul(x, x);
  }
};
struct SquaresAbout {
  static constexpr int cost = 3;
  const float* a;
  float offset;
  template <class T>
  EIGEN_ALWAYS_INLINE T at(int i) const {
    const T x = Eigen::internal::psub(load<T>(a + i), Eigen::internal::pset1<T>(offset));
    return Eigen::internal::pmul(x, x);
  }
};

template <class T, int Step, int N, class Terms>
EIGEN_ALWAYS_INLINE T sum_by_halves(const Terms& terms, int begin) {
  if constexpr (N == 1) {
    return terms.template at<T>(begin);
  } else {
    return Eigen::internal::padd(sum_by_halves<T, Step, N / 2>(terms, begin),
                                 sum_by_halves<T, Step, N - N / 2>(terms, begin + N / 2 * Step));
  }
}

template <int N, class Terms>
inline float sum(const Terms& terms) {
  constexpr int P = patch_packet, packets = N / P, pairs = packets / 2;
  Packet sum;
  if constexpr (N * Terms::cost + N - 1 <= 110 * P) {
    sum = sum_by_halves<Packet, P, packets>(terms, 0);
  } else {
    Packet even = terms.template at<Packet>(0), odd = terms.template at<Packet>(P);
    for (int i = 2 * P; i < pairs * 2 * P; i += 2 * P) {
      even = Eigen::internal::padd(even, terms.template at<Packet>(i));
      odd = Eigen::internal::padd(odd, terms.template at<Packet>(i + P));
    }
    sum = Eigen::internal::padd(even, odd);
    if constexpr (packets % 2 == 1) sum = Eigen::internal::padd(sum, terms.template at<Packet>(pairs * 2 * P));
  }
  float out = Eigen::internal::predux(sum);
  if constexpr (N % P != 0) out += sum_by_halves<float, 1, N % P>(terms, packets * P);
  return out;
}
}  // namespace detail

template <int N>
float mean_of(const Vec<float, N>& a) {
  return detail::sum<N>(detail::Samples{a.data()}) / float(N);
}
/// a . b
template <int N>
float sum_of_products(const Vec<float, N>& a, const Vec<float, N>& b) {
  return detail::sum<N>(detail::Products{a.data(), b.data()});
}
/// a . a
template <int N>
float sum_of_squares(const Vec<float, N>& a) {
  return detail::sum<N>(detail::Squares{a.data()});
}
/// Sum of (a_j - offset)^2.
template <int N>
float squared_norm_about(const Vec<float, N>& a, float offset) {
  return detail::sum<N>(detail::SquaresAbout{a.data(), offset});
}

}  // namespace plumbline

#pragma GCC diagnostic pop
