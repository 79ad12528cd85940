// Startup of a Cortex-M7: vector table, memory, FPU, constructors, main.
#include <cstdint>
#include <cstring>

#include "board.hpp"

extern "C" {
extern std::uint32_t stack_begin[], stack_end[], bss_begin[], bss_end[], data_begin[], data_end[], data_source[];
extern void (*init_begin[])();
extern void (*init_end[])();
int main();

[[noreturn]] void reset();
[[noreturn]] void fault() { board::exit(3); }
void systick() { board::on_tick(); }
// Where the C library ends up when all is lost.
[[noreturn]] void abort() { board::exit(4); }
}

namespace {

using Handler = void (*)();
struct Vectors {
  std::uint32_t* stack;
  Handler handlers[15];
};
[[gnu::section(".vectors"), gnu::used]] const Vectors vectors = {
    stack_end,
    {reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, systick}};

volatile std::uint32_t& coprocessor_access = *reinterpret_cast<volatile std::uint32_t*>(0xe000ed88);

}  // namespace

void reset() {
  coprocessor_access = coprocessor_access | 0xf << 20;  // FPU
  asm volatile("dsb\n isb" ::: "memory");
  std::memcpy(data_begin, data_source, std::size_t(data_end - data_begin) * 4);
  std::memset(bss_begin, 0, std::size_t(bss_end - bss_begin) * 4);
  for (auto init = init_begin; init != init_end; ++init) (*init)();
  main();
  board::exit(0);
}

// The stack below the caller's frame is filled with a pattern; what of it is left has never been used.
void board::paint_stack() {
  const auto* top = static_cast<std::uint32_t*>(__builtin_frame_address(0)) - 64;
  for (volatile std::uint32_t* word = stack_begin; word < top; ++word) *word = 0x5aa55aa5;
}

std::uint32_t board::used_stack() {
  const std::uint32_t* word = stack_begin;
  while (word < stack_end && *word == 0x5aa55aa5) ++word;
  return std::uint32_t(stack_end - word) * 4;
}
