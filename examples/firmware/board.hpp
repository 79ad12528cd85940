#pragma once
/// What the example uses of the board: a periodic interrupt, a clock, a serial line, and the end of the emulation.

#include <cstdint>

namespace board {

inline constexpr std::uint32_t clock_hz = 25'000'000;

namespace registers {

inline volatile std::uint32_t& at(std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); }
inline volatile std::uint32_t& systick_control() { return at(0xe000e010); }
inline volatile std::uint32_t& systick_reload() { return at(0xe000e014); }
inline volatile std::uint32_t& systick_value() { return at(0xe000e018); }
inline volatile std::uint32_t& timer_control() { return at(0x40000000); }
inline volatile std::uint32_t& timer_value() { return at(0x40000004); }
inline volatile std::uint32_t& timer_reload() { return at(0x40000008); }
inline volatile std::uint32_t& uart_data() { return at(0x40004000); }
inline volatile std::uint32_t& uart_state() { return at(0x40004004); }
inline volatile std::uint32_t& uart_control() { return at(0x40004008); }
inline volatile std::uint32_t& uart_divider() { return at(0x40004010); }

}  // namespace registers

/// The interrupt handler of SysTick, which the program defines.
void on_tick();

inline void start_ticks(std::uint32_t per_second) {
  registers::systick_reload() = clock_hz / per_second - 1;
  registers::systick_value() = 0;
  registers::systick_control() = 7;  // the processor's clock, interrupt, on
}

/// Starts the clock and the serial line.
inline void start() {
  registers::timer_reload() = 0xffffffff;
  registers::timer_value() = 0xffffffff;
  registers::timer_control() = 1;
  registers::uart_divider() = 16;
  registers::uart_control() = 1;
}

/// Ticks of the clock since `start`; they overflow after 171 s.
inline std::uint32_t ticks() { return 0xffffffff - registers::timer_value(); }

inline void wait_for_interrupt() { asm volatile("wfi" ::: "memory"); }

inline void write(char c) {
  while (registers::uart_state() & 1) {
  }
  registers::uart_data() = std::uint32_t(c);
}

/// Ends the emulation with this status; a board without debugger stops here.
[[noreturn]] inline void exit(std::uint32_t status) {
  const std::uint32_t block[2] = {0x20026, status};   // ADP_Stopped_ApplicationExit
  register std::uint32_t operation asm("r0") = 0x20;  // SYS_EXIT_EXTENDED
  register const std::uint32_t* argument asm("r1") = block;
  asm volatile("bkpt 0xab" : "+r"(operation) : "r"(argument) : "memory");
  for (;;) wait_for_interrupt();
}

void paint_stack();          ///< before the first frame
std::uint32_t used_stack();  ///< since then at most [byte]

}  // namespace board
