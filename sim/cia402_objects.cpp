#include "sim/cia402_objects.hpp"

#include <string_view>

#include "inbetween/can/pdo.hpp"

namespace inbetween {
namespace {

using Access = ObjectDictionary::Access;

constexpr std::uint8_t u8 = 1;
constexpr std::uint8_t u16 = 2;
constexpr std::uint8_t u32 = 4;

void add_pdo(ObjectDictionary& objects, unsigned communication, unsigned mapping, std::uint32_t cob_id) {
  const auto comm = static_cast<std::uint16_t>(communication);
  const auto map = static_cast<std::uint16_t>(mapping);
  const bool is_sent = communication >= 0x1800;
  objects.add({.index = comm, .sub = 0},
              {.size = u8, .access = Access::read_only, .value = is_sent ? 6U : 5U});
  objects.add({.index = comm, .sub = 1}, {.size = u32, .value = cob_id});
  objects.add({.index = comm, .sub = 2}, {.size = u8, .value = 255});
  objects.add({.index = comm, .sub = 3}, {.size = u16});
  objects.add({.index = comm, .sub = 5}, {.size = u16});
  if (is_sent) objects.add({.index = comm, .sub = 6}, {.size = u8});
  objects.add({.index = map, .sub = 0}, {.size = u8, .value = 1});
  for (std::uint8_t sub = 1; sub <= 8; ++sub) objects.add({.index = map, .sub = sub}, {.size = u32});
  objects.set(map, 1, is_sent ? 0x60410010 : 0x60400010);
}

void add_communication(ObjectDictionary& objects, can::NodeId node) {
  const auto fixed = [&](std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
    objects.add({.index = index, .sub = sub}, {.size = size, .access = Access::read_only, .value = value});
  };
  fixed(0x1000, 0, u32, 0x00020192);
  fixed(0x1001, 0, u8, 0);
  objects.add({.index = 0x1005}, {.size = u32, .value = can::sync_id.number()});
  objects.add({.index = 0x1006}, {.size = u32});
  const std::string_view name = "simulated CiA 402 drive";
  objects.add({.index = 0x1008}, {.access = Access::read_only, .bytes = {name.begin(), name.end()}});
  objects.add({.index = 0x100C}, {.size = u16});
  objects.add({.index = 0x100D}, {.size = u8});
  fixed(0x1016, 0, u8, 1);
  objects.add({.index = 0x1016, .sub = 1}, {.size = u32});
  objects.add({.index = 0x1017}, {.size = u16});
  fixed(0x1018, 0, u8, 4);
  for (std::uint8_t sub = 1; sub <= 4; ++sub) fixed(0x1018, sub, u32, 0x5100U + sub);
  objects.add({.index = 0x1019}, {.size = u8, .max = 240});
  fixed(0x1029, 0, u8, 1);
  objects.add({.index = 0x1029, .sub = 1}, {.size = u8, .value = 1, .max = 2});
  for (unsigned n = 0; n < 4; ++n) {
    const std::uint32_t number = 0x100 * n + node.value();
    add_pdo(objects, 0x1400 + n, 0x1600 + n, 0x200 + number);
    add_pdo(objects, 0x1800 + n, 0x1A00 + n, can::cob_id_without_rtr | (0x180 + number));
  }
}

}  // namespace

ObjectDictionary factory_objects(can::NodeId node) {
  ObjectDictionary objects;
  add_communication(objects, node);
  const auto shown = [&](std::uint16_t index, std::uint8_t size, std::uint32_t value) {
    objects.add({.index = index}, {.size = size, .access = Access::read_only, .value = value});
  };
  shown(0x603F, u16, 0);
  objects.add({.index = 0x6007}, {.size = u16, .value = 1, .max = 3});
  objects.add({.index = 0x6040}, {.size = u16});
  shown(0x6041, u16, 0);
  objects.add({.index = 0x605A}, {.size = u16, .value = 2, .max = 8});
  objects.add({.index = 0x605B}, {.size = u16, .value = 0, .max = 1});
  objects.add({.index = 0x605C}, {.size = u16, .value = 1, .max = 1});
  objects.add({.index = 0x605D}, {.size = u16, .value = 1, .max = 4});
  objects.add({.index = 0x605E}, {.size = u16, .value = 2, .max = 4});
  objects.add({.index = 0x6060}, {.size = u8, .value = 1});
  shown(0x6061, u8, 1);
  shown(0x6064, u32, 0);
  objects.add({.index = 0x6065}, {.size = u32, .value = 2000});
  objects.add({.index = 0x6066}, {.size = u16, .value = 10});
  shown(0x606C, u32, 0);
  objects.add({.index = 0x607A}, {.size = u32});
  objects.add({.index = 0x607B, .sub = 1}, {.size = u32, .value = 0x80000000});
  objects.add({.index = 0x607B, .sub = 2}, {.size = u32, .value = 0x7FFFFFFF});
  objects.add({.index = 0x607C}, {.size = u32});
  objects.add({.index = 0x607D, .sub = 1}, {.size = u32});
  objects.add({.index = 0x607D, .sub = 2}, {.size = u32});
  objects.add({.index = 0x6085}, {.size = u32, .value = 500'000, .min = 1});
  objects.add({.index = 0x6098}, {.size = u8, .max = 37});
  objects.add({.index = 0x6099, .sub = 1}, {.size = u32, .value = 1000, .min = 1});
  objects.add({.index = 0x6099, .sub = 2}, {.size = u32, .value = 100, .min = 1});
  objects.add({.index = 0x609A}, {.size = u32, .value = 10'000, .min = 1});
  objects.add({.index = 0x60C2, .sub = 1}, {.size = u8, .value = 20, .min = 1});
  objects.add({.index = 0x60C2, .sub = 2}, {.size = u8, .value = 0xFD});
  objects.add({.index = 0x60C0}, {.size = u16, .max = 0});
  objects.add({.index = 0x60C1, .sub = 1}, {.size = u32});
  shown(0x60F4, u32, 0);
  shown(0x6502, u32, 0xE1);
  return objects;
}

}  // namespace inbetween
