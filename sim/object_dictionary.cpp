#include "sim/object_dictionary.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace inbetween {
namespace {

std::uint32_t number_of(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint32_t{bytes[i]} << (8 * i);
  return value;
}

}  // namespace

std::vector<ObjectDictionary::Entry>::const_iterator ObjectDictionary::from(
    can::ObjectAddress address) const {
  return std::ranges::lower_bound(objects_, key(address), {}, &Entry::first);
}

void ObjectDictionary::add(can::ObjectAddress address, const Object& object) {
  ++revision_;
  const auto next = objects_.begin() + (from(address) - objects_.cbegin());
  if (next != objects_.end() && next->first == key(address)) {
    next->second = object;
    return;
  }
  objects_.insert(next, {key(address), object});
}

void ObjectDictionary::remove(can::ObjectAddress address) {
  ++revision_;
  std::erase_if(objects_, [&](const Entry& entry) { return entry.first == key(address); });
}

ObjectDictionary::Place ObjectDictionary::place_of(std::uint16_t index, std::uint8_t sub) const {
  const can::ObjectAddress address{.index = index, .sub = sub};
  const auto found = from(address);
  const bool is_there = found != objects_.end() && found->first == key(address);
  return static_cast<Place>((is_there ? found : objects_.end()) - objects_.begin());
}

const ObjectDictionary::Object* ObjectDictionary::find(can::ObjectAddress address) const {
  const auto place = static_cast<std::size_t>(place_of(address.index, address.sub));
  return place < objects_.size() ? &objects_[place].second : nullptr;
}

const ObjectDictionary::Object& ObjectDictionary::at(can::ObjectAddress address) const {
  if (const Object* const object = find(address)) return *object;
  throw std::out_of_range("a simulated drive has no such object");
}

std::uint32_t ObjectDictionary::value(std::uint16_t index, std::uint8_t sub) const {
  return value(place_of(index, sub));
}

void ObjectDictionary::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
  set(place_of(index, sub), value);
}

std::vector<std::uint8_t> ObjectDictionary::read(can::ObjectAddress address) const {
  const Object& object = at(address);
  if (!object.bytes.empty()) return object.bytes;
  std::vector<std::uint8_t> bytes;
  for (unsigned i = 0; i < object.size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(object.value >> (8 * i)));
  return bytes;
}

void ObjectDictionary::write(can::ObjectAddress address, const std::vector<std::uint8_t>& bytes) {
  Object* const object = find_own(address);
  if (object == nullptr || object->access == Access::write_ignored) return;
  ++revision_;
  object->bytes.empty() ? void(object->value = number_of(bytes)) : void(object->bytes = bytes);
}

void ObjectDictionary::change_access(can::ObjectAddress address, Access access) {
  ++revision_;
  if (Object* const object = find_own(address)) object->access = access;
}

void ObjectDictionary::restore(const ObjectDictionary& defaults, std::uint16_t first, std::uint16_t last) {
  ++revision_;
  for (auto& [key, object] : objects_) {
    const std::uint32_t index = key >> 8;
    const Object* const before = defaults.find(
        {.index = static_cast<std::uint16_t>(index), .sub = static_cast<std::uint8_t>(key & 0xFFU)});
    if (index < first || index > last || before == nullptr) continue;
    object.value = before->value;
    object.bytes = before->bytes;
  }
}

std::uint32_t ObjectDictionary::reason_not_there(can::ObjectAddress address) const {
  const auto next = from({.index = address.index});
  const bool has_index = next != objects_.end() && next->first >> 8 == address.index;
  return has_index ? can::abort_no_sub_index : can::abort_no_object;
}

std::optional<std::uint32_t> ObjectDictionary::refuses_read(can::ObjectAddress address) const {
  const Object* const found = find(address);
  if (found == nullptr) return reason_not_there(address);
  if (found->access == Access::write_only) return can::abort_write_only;
  return {};
}

std::optional<std::uint32_t> ObjectDictionary::refuses_length(can::ObjectAddress address,
                                                              std::size_t length) const {
  const Object* const found = find(address);
  if (found == nullptr) return reason_not_there(address);
  if (found->access == Access::read_only) return can::abort_read_only;
  if (found->access == Access::write_refused) return can::abort_device_state;
  const std::size_t own = found->bytes.empty() ? found->size : found->bytes.size();
  if (length != own) return can::abort_wrong_length;
  return {};
}

std::optional<std::uint32_t> ObjectDictionary::refuses_write(can::ObjectAddress address,
                                                             const std::vector<std::uint8_t>& bytes) const {
  if (const auto why = refuses_length(address, bytes.size())) return why;
  const Object& object = at(address);
  if (!object.bytes.empty()) return {};
  const std::uint32_t value = number_of(bytes);
  if (value > object.max) return can::abort_too_high;
  if (value < object.min) return can::abort_too_low;
  return {};
}

}  // namespace inbetween
