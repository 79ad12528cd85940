#pragma once
/// What the world may answer: a value or a named error. Follows std::expected, so that C++23 can take over.

#include <cstdint>
#include <utility>
#include <variant>

namespace plumbline {

/// Why a per-frame call could not be served. The estimator stays usable after each of them.
enum class Error : std::uint8_t {
  late_sample,            ///< time stamp not after the previous one of the same sensor
  wrong_image_size,       ///< image or depth image differs from the calibrated resolution
  not_finite,             ///< NaN or infinity in a sample
  too_few_features,       ///< not enough observations to estimate a pose
  not_positive_definite,  ///< the normal equations are singular
  not_initialized,        ///< no estimate yet
};

template <class T>
class [[nodiscard]] Result {
 public:
  constexpr Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  constexpr Result(Error error) : state_(std::in_place_index<1>, error) {}
  constexpr explicit operator bool() const noexcept { return state_.index() == 0; }
  constexpr const T* operator->() const noexcept { return std::get_if<0>(&state_); }
  constexpr const T& operator*() const noexcept { return *std::get_if<0>(&state_); }
  constexpr Error error() const noexcept { return *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

/// The error's name, for logs.
constexpr const char* name_of(Error error) {
  switch (error) {
    case Error::late_sample: return "late sample";
    case Error::wrong_image_size: return "wrong image size";
    case Error::not_finite: return "not finite";
    case Error::too_few_features: return "too few features";
    case Error::not_positive_definite: return "not positive definite";
    case Error::not_initialized: return "not initialized";
  }
  return "unknown error";
}

}  // namespace plumbline
