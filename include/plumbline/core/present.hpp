#pragma once
/// A member that only some types have. Where it is absent it takes no memory, reads as nothing and swallows what is
/// written to it, so that code which could have it is the same text for both:
///
///   [[no_unique_address]] Present<InverseDepth<S>, Sensors::has_depth> depth;
///
/// Two absent members of one class need different tags: two empty members of one type need two addresses.

#include "plumbline/core/matrix_functions.hpp"

namespace plumbline {

namespace detail {
/// Zero of a matrix, else what the default constructor makes.
template <class T>
T nothing() {
  if constexpr (requires { T::Zero(); }) {
    return zeros<T>();
  } else {
    return T{};
  }
}
}  // namespace detail

template <class T, bool present, int tag = 0>
class Present {
 public:
  Present() = default;
  Present(const T& value) : value_(value) {}

  const T& get() const { return value_; }
  void set(const T& value) { value_ = value; }

 private:
  T value_ = detail::nothing<T>();
};

template <class T, int tag>
class Present<T, false, tag> {
 public:
  Present() = default;
  Present(const T&) {}

  T get() const { return detail::nothing<T>(); }
  void set(const T&) {}
};

}  // namespace plumbline
