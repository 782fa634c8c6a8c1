#include "examples/firmware/board.hpp"

/// Arm MPS2 with the images AN386 and AN500: SysTick (Armv7-M Architecture Reference Manual, B3.3) at the
/// processor's 25 MHz, the first CMSDK APB UART (Cortex-M System Design Kit, 4.3), and semihosting
/// (Arm IHI 0089) for the end.

namespace inbetween::board {
namespace {

template <std::uint32_t Address>
volatile std::uint32_t& device_register() {
  return *reinterpret_cast<volatile std::uint32_t*>(Address);
}

constexpr std::uint32_t systick_control = 0xE000E010;
constexpr std::uint32_t systick_reload = 0xE000E014;
constexpr std::uint32_t systick_value = 0xE000E018;
constexpr std::uint32_t systick_on = 0b101;  ///< enabled, counting processor clocks
constexpr std::uint32_t systick_interrupt = 0b010;

constexpr std::uint32_t uart_data = 0x40004000;
constexpr std::uint32_t uart_state = 0x40004004;
constexpr std::uint32_t uart_control = 0x40004008;
constexpr std::uint32_t uart_bauddiv = 0x40004010;
constexpr std::uint32_t uart_full = 0b1;
constexpr std::uint32_t uart_transmit = 0b1;
constexpr std::uint32_t baud = 115'200;

std::uint32_t volatile due = 0;  ///< ticks that have come; written by the interrupt only
std::uint32_t handed_out = 0;    ///< ... and that the program knows of
std::int64_t last_tick_number = -1;

void start_systick(std::uint32_t period, std::uint32_t mode) {
  device_register<systick_reload>() = period - 1;
  device_register<systick_value>() = 0;
  device_register<systick_control>() = mode;
}

}  // namespace

void start_tick(std::int32_t rate_hz) {
  start_systick(clock_hz / static_cast<std::uint32_t>(rate_hz), systick_on | systick_interrupt);
}

void on_tick() {
  due = due + 1;
}

std::int64_t wait_for_tick() {
  // Without the lock an interrupt between the question and the sleep would be slept through; a pending one
  // wakes the processor nevertheless.
  asm volatile("cpsid i" ::: "memory");
  while (due == handed_out) asm volatile("wfi\n cpsie i\n isb\n cpsid i" ::: "memory");
  const std::uint32_t now = due;
  asm volatile("cpsie i" ::: "memory");
  last_tick_number += now - handed_out;
  handed_out = now;
  return last_tick_number;
}

void send(std::string_view text) {
  if (device_register<uart_control>() == 0) {
    device_register<uart_bauddiv>() = clock_hz / baud;
    device_register<uart_control>() = uart_transmit;
  }
  for (const char character : text) {
    while ((device_register<uart_state>() & uart_full) != 0) {
    }
    device_register<uart_data>() = static_cast<unsigned char>(character);
  }
}

void start_clock() {
  start_systick(clock_mask + 1, systick_on);
}

std::uint32_t clock_now() {
  return clock_mask - device_register<systick_value>();  // SysTick counts down
}

void finish(bool success) {
  constexpr std::uint32_t sys_exit_extended = 0x20;
  constexpr std::uint32_t application_exit = 0x20026;
  const std::uint32_t parameters[2] = {application_exit, success ? 0U : 1U};
  register std::uint32_t operation asm("r0") = sys_exit_extended;
  register const std::uint32_t* block asm("r1") = parameters;
  asm volatile("bkpt 0xAB" : "+r"(operation) : "r"(block) : "memory");
  for (;;) asm volatile("wfi");
}

}  // namespace inbetween::board
