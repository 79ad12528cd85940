#pragma once
/// One line of text for each frame, in hexadecimal digits so that every bit is there and no printf is needed:
///
///   frame <t_ns> <health state> <reason> <keyframe> <p x y z> <q x y z w> <ticks of add_frame> <ticks of idle work>
///   end <sizeof of the estimator> <stack in use at most> <IMU samples refused> <times the queue was full>

#include <bit>
#include <cstdint>

#include "plumbline/estimator/estimate.hpp"

/// `write(char)` takes the text.
template <class Write>
class LineWriter {
 public:
  explicit LineWriter(Write write) : write_(write) {}

  void begin(const char* word) {
    while (*word != '\0') write_(*word++);
  }
  void hex(std::uint64_t value, int digits = 8) {
    write_(' ');
    for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) write_("0123456789abcdef"[value >> shift & 15]);
  }
  void end() { write_('\n'); }

  void frame(const plumbline::Estimate<float>& estimate, std::uint32_t frame_ticks, std::uint32_t idle_ticks) {
    begin("frame");
    hex(std::uint64_t(estimate.t_ns), 16);
    hex(std::uint32_t(estimate.health.state), 2);
    hex(std::uint32_t(estimate.health.reason), 2);
    hex(estimate.keyframe, 2);
    for (int i = 0; i < 3; ++i) hex(std::bit_cast<std::uint32_t>(estimate.T_world_body.p()[i]));
    for (int i = 0; i < 4; ++i)
      hex(std::bit_cast<std::uint32_t>(estimate.T_world_body.rotation().quaternion().coeffs()[i]));
    hex(frame_ticks);
    hex(idle_ticks);
    end();
  }

 private:
  Write write_;
};
