#include "sim/object_dictionary.hpp"

namespace inbetween {
namespace {

std::uint32_t number_of(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint32_t{bytes[i]} << (8 * i);
  return value;
}

}  // namespace

const ObjectDictionary::Object* ObjectDictionary::find(can::ObjectAddress address) const {
  const auto found = objects_.find(key(address));
  return found == objects_.end() ? nullptr : &found->second;
}

std::uint32_t ObjectDictionary::value(std::uint16_t index, std::uint8_t sub) const {
  const Object* const object = find({.index = index, .sub = sub});
  return object == nullptr ? 0 : object->value;
}

void ObjectDictionary::set(std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
  const auto found = objects_.find(key({.index = index, .sub = sub}));
  if (found != objects_.end())
    found->second.value = value & (0xFFFFFFFFU >> (8U * (4U - found->second.size)));
}

std::vector<std::uint8_t> ObjectDictionary::read(can::ObjectAddress address) const {
  const Object& object = objects_.at(key(address));
  if (!object.bytes.empty()) return object.bytes;
  std::vector<std::uint8_t> bytes;
  for (unsigned i = 0; i < object.size; ++i)
    bytes.push_back(static_cast<std::uint8_t>(object.value >> (8 * i)));
  return bytes;
}

void ObjectDictionary::write(can::ObjectAddress address, const std::vector<std::uint8_t>& bytes) {
  Object& object = objects_.at(key(address));
  if (object.access == Access::write_ignored) return;
  object.bytes.empty() ? void(object.value = number_of(bytes)) : void(object.bytes = bytes);
}

void ObjectDictionary::change_access(can::ObjectAddress address, Access access) {
  const auto found = objects_.find(key(address));
  if (found != objects_.end()) found->second.access = access;
}

void ObjectDictionary::restore(const ObjectDictionary& defaults, std::uint16_t first, std::uint16_t last) {
  for (auto& [key, object] : objects_) {
    const std::uint32_t index = key >> 8;
    const auto found = defaults.objects_.find(key);
    if (index < first || index > last || found == defaults.objects_.end()) continue;
    object.value = found->second.value;
    object.bytes = found->second.bytes;
  }
}

std::uint32_t ObjectDictionary::reason_not_there(can::ObjectAddress address) const {
  const auto next = objects_.lower_bound(key({.index = address.index}));
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
  const Object& object = objects_.at(key(address));
  if (!object.bytes.empty()) return {};
  const std::uint32_t value = number_of(bytes);
  if (value > object.max) return can::abort_too_high;
  if (value < object.min) return can::abort_too_low;
  return {};
}

}  // namespace inbetween
