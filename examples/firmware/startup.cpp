#include <cstdint>

#include "examples/firmware/board.hpp"

/// From reset to the program, on a Cortex-M with a floating-point unit (Armv7-M Architecture Reference
/// Manual, B1.5: exception model; B3.2.20: CPACR).

extern "C" {
// Addresses that the linker script defines.
extern std::uint32_t stack_top, data_begin, data_end, bss_begin, bss_end;
extern const std::uint32_t data_load;
using Initializer = void (*)();
extern const Initializer init_array_begin, init_array_end;

[[noreturn]] void reset();
[[noreturn]] void fault();
}

namespace {

/// After reset nobody may use the floating-point unit: bits 20 to 23 of the coprocessor access register
/// open it. The barriers hold back the first floating-point instruction.
void enable_floating_point() {
  constexpr std::uint32_t cpacr_address = 0xE000ED88;
  auto& cpacr = *reinterpret_cast<volatile std::uint32_t*>(cpacr_address);
  cpacr = cpacr | (0xFU << 20);
  asm volatile("dsb\n isb" ::: "memory");
}

void initialize_memory() {
  const std::uint32_t* from = &data_load;
  for (std::uint32_t* to = &data_begin; to != &data_end; ++to) *to = *from++;
  for (std::uint32_t* to = &bss_begin; to != &bss_end; ++to) *to = 0;
  for (const Initializer* call = &init_array_begin; call != &init_array_end; ++call) (*call)();
}

}  // namespace

extern "C" void reset() {
  enable_floating_point();
  initialize_memory();
  inbetween::board::finish(inbetween::board::program());
}

/// Whatever the program does not expect ends it: a defect must not look like a standstill.
extern "C" void fault() {
  inbetween::board::finish(false);
}

namespace {

/// What the processor reads at address 0: the first stack pointer, then a handler per exception.
struct VectorTable {
  std::uint32_t* initial_stack;
  void (*handlers[15])();
};

__attribute__((section(".vectors"), used)) const VectorTable vectors{
    &stack_top,
    {
        reset, fault, fault, fault, fault, fault,  // reset, NMI, hard, memory, bus and usage fault
        nullptr, nullptr, nullptr, nullptr,        // reserved
        fault, fault, nullptr, fault,              // SVCall, debug monitor, reserved, PendSV
        inbetween::board::on_tick,                 // SysTick
    }};

}  // namespace
