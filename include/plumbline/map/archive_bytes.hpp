#pragma once
/// Little-endian numbers in a sequence of bytes, whatever the machine, with a CRC-32 (IEEE 802.3) over them.
///
///   a sink is called with spans of bytes:   sink(std::span<const std::byte>)

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"

namespace plumbline {

/// The checksum of `bytes` after others, whose checksum is `before`.
inline std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0) {
  std::uint32_t crc = ~before;
  for (const std::byte b : bytes) {
    crc ^= std::to_integer<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xEDB88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

template <class Sink>
class ArchiveWriter {
 public:
  explicit ArchiveWriter(Sink& sink) : sink_(sink) {}

  std::uint32_t checksum() const { return crc_; }
  void text(std::span<const char> characters) {
    for (const char c : characters) number(static_cast<std::uint8_t>(c));
  }
  template <class T>
  requires(std::is_unsigned_v<T>) void number(T value) {
    std::array<std::byte, sizeof(T)> bytes;
    for (std::size_t k = 0; k < sizeof(T); ++k) bytes[k] = static_cast<std::byte>(value >> (8 * k) & 0xFF);
    crc_ = crc32(bytes, crc_);
    sink_(std::span<const std::byte>(bytes));
  }
  void number(std::int64_t value) { number(static_cast<std::uint64_t>(value)); }
  void number(float value) { number(std::bit_cast<std::uint32_t>(value)); }
  void number(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  void position(const Vec<double, 3>& p) {
    for (int k = 0; k < 3; ++k) number(p[k]);
  }
  void rotation(const SO3<double>& R) {
    for (int k = 0; k < 4; ++k) number(R.quaternion().coeffs()[k]);  // x y z w
  }
  void pose(const SE3<double>& T) {
    rotation(T.rotation());
    position(T.p());
  }
  void similarity(const Sim3<double>& T) {
    number(T.scale());
    rotation(T.rotation());
    position(T.t());
  }
  /// The upper triangle, row by row.
  template <int N>
  void symmetric(const Mat<double, N, N>& A, int size = N) {
    for (int i = 0; i < size; ++i)
      for (int j = i; j < size; ++j) number(A(i, j));
  }

 private:
  Sink& sink_;
  std::uint32_t crc_ = 0;
};

/// Reads what ArchiveWriter wrote. After the first number that is not there, is not finite or beyond `largest`, or a
/// rotation that is none, `is_good` is false; what is read then is of no use.
class ArchiveReader {
 public:
  static constexpr double largest = 1e12;  ///< of a position, a variance, ...; numerics: float has their products

  explicit ArchiveReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  bool is_good() const { return is_good_; }
  std::size_t left() const { return rest_.size(); }
  bool text(std::span<const char> expected) {
    bool same = true;
    for (const char c : expected) same = number<std::uint8_t>() == static_cast<std::uint8_t>(c) && same;
    return same && is_good_;
  }
  template <class T>
  requires(std::is_unsigned_v<T>) T number() {
    if (rest_.size() < sizeof(T)) {
      is_good_ = false;
      return T(0);
    }
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < sizeof(T); ++k) value |= std::to_integer<std::uint64_t>(rest_[k]) << (8 * k);
    rest_ = rest_.subspan(sizeof(T));
    return static_cast<T>(value);
  }
  std::int64_t time() { return static_cast<std::int64_t>(number<std::uint64_t>()); }
  float real32() { return checked(std::bit_cast<float>(number<std::uint32_t>())); }
  double real64() { return checked(std::bit_cast<double>(number<std::uint64_t>())); }
  Vec<double, 3> position() {
    Vec<double, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = real64();
    return p;
  }
  SO3<double> rotation() {
    Vec<double, 4> q;
    for (int k = 0; k < 4; ++k) q[k] = real64();
    is_good_ = is_good_ && std::abs(squared_norm(q) - 1) < 1e-3;
    return is_good_ ? SO3<double>(Eigen::Quaternion<double>(q[3], q[0], q[1], q[2])) : SO3<double>();
  }
  SE3<double> pose() {
    const SO3<double> R = rotation();
    return SE3<double>(R, position());
  }
  Sim3<double> similarity() {
    const double scale = real64();
    const float rounded = static_cast<float>(is_good_ ? scale : 1);  // as a map in float has it, and saves it again
    is_good_ = is_good_ && rounded > 1e-9f && rounded < 1e9f;
    const SO3<double> R = rotation();
    return Sim3<double>(is_good_ ? scale : 1, R, position());
  }
  template <int N>
  Mat<double, N, N> symmetric(int size = N) {
    Mat<double, N, N> A = zeros<double, N, N>();
    for (int i = 0; i < size; ++i)
      for (int j = i; j < size; ++j) A(i, j) = A(j, i) = real64();
    return A;
  }

 private:
  template <class T>
  T checked(T value) {
    is_good_ = is_good_ && std::abs(value) <= T(largest);  // not NaN
    return value;
  }

  std::span<const std::byte> rest_;
  bool is_good_ = true;
};

}  // namespace plumbline
