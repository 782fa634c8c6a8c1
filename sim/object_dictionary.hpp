#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "inbetween/can/sdo.hpp"

namespace inbetween {

/// The objects of a simulated CANopen device: numbers of one to four bytes with their access and range, and
/// bytes, such as its name. Each refusal has the abort code of CiA 301.
class ObjectDictionary {
 public:
  /// write_refused: not in the state of the device. write_ignored: a broken device, which says yes and keeps
  /// what it has. silent: one that does not answer at all.
  enum class Access : std::uint8_t {
    read_only,
    read_write,
    write_only,
    write_refused,
    write_ignored,
    silent
  };
  struct Object {
    std::uint8_t size = 4;
    Access access = Access::read_write;
    std::uint32_t value = 0;
    std::uint32_t min = 0;  ///< compared without sign
    std::uint32_t max = std::numeric_limits<std::uint32_t>::max();
    bool can_be_mapped = true;  ///< into a PDO
    /// Of an object that is no number: it keeps its length, and what is above but the access says nothing.
    std::vector<std::uint8_t> bytes = {};
  };

  void add(can::ObjectAddress address, const Object& object);
  /// A device that does not have it.
  void remove(can::ObjectAddress address);
  [[nodiscard]] const Object* find(can::ObjectAddress address) const;
  /// Grows whenever anything changes but by set().
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

  [[nodiscard]] bool is_silent(can::ObjectAddress address) const {
    const Object* const object = find(address);
    return object != nullptr && object->access == Access::silent;
  }
  /// As the device itself sees it; 0 where there is none.
  [[nodiscard]] std::uint32_t value(std::uint16_t index, std::uint8_t sub = 0) const;
  void set(std::uint16_t index, std::uint8_t sub, std::uint32_t value);
  /// Where an object is, or that it is nowhere, for as long as revision() stays: a device looks at a dozen of
  /// them for every frame that it hears.
  enum class Place : std::size_t {};
  [[nodiscard]] Place place_of(std::uint16_t index, std::uint8_t sub = 0) const;
  [[nodiscard]] std::uint32_t value(Place place) const {
    const auto at = static_cast<std::size_t>(place);
    return at < objects_.size() ? objects_[at].second.value : 0;
  }
  void set(Place place, std::uint32_t value) {
    const auto at = static_cast<std::size_t>(place);
    if (at >= objects_.size()) return;
    Object& object = objects_[at].second;
    object.value = value & (0xFFFFFFFFU >> (8U * (4U - object.size)));
  }
  /// As a client reads it, a number from its lowest byte on, once nothing refuses that.
  [[nodiscard]] std::vector<std::uint8_t> read(can::ObjectAddress address) const;
  /// As a client writes it, once nothing refuses that.
  void write(can::ObjectAddress address, const std::vector<std::uint8_t>& bytes);
  void change_access(can::ObjectAddress address, Access access);
  /// The values of another dictionary, from one index to the other.
  void restore(const ObjectDictionary& defaults, std::uint16_t first, std::uint16_t last);

  /// Why a client may not read or write it; nothing where it may.
  [[nodiscard]] std::optional<std::uint32_t> refuses_read(can::ObjectAddress address) const;
  [[nodiscard]] std::optional<std::uint32_t> refuses_write(can::ObjectAddress address,
                                                           const std::vector<std::uint8_t>& bytes) const;
  /// The same before the bytes are known.
  [[nodiscard]] std::optional<std::uint32_t> refuses_length(can::ObjectAddress address,
                                                            std::size_t length) const;

 private:
  [[nodiscard]] std::uint32_t reason_not_there(can::ObjectAddress address) const;
  static std::uint32_t key(can::ObjectAddress address) {
    return (std::uint32_t{address.index} << 8) | address.sub;
  }
  using Entry = std::pair<std::uint32_t, Object>;
  /// The first at this address or behind it.
  [[nodiscard]] std::vector<Entry>::const_iterator from(can::ObjectAddress address) const;
  [[nodiscard]] Object* find_own(can::ObjectAddress address) {
    return const_cast<Object*>(find(address));  // NOLINT(cppcoreguidelines-pro-type-const-cast): it is ours
  }
  /// One that is there. Throws std::out_of_range.
  [[nodiscard]] const Object& at(can::ObjectAddress address) const;

  std::vector<Entry> objects_;  ///< in the order of their addresses
  std::uint64_t revision_ = 0;
};

}  // namespace inbetween
