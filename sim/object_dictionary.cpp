#include "sim/object_dictionary.hpp"

namespace inbetween {

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

void ObjectDictionary::write(can::ObjectAddress address, std::uint32_t value) {
  const Object* const object = find(address);
  if (object != nullptr && object->access != Access::write_ignored) set(address.index, address.sub, value);
}

void ObjectDictionary::change_access(can::ObjectAddress address, Access access) {
  const auto found = objects_.find(key(address));
  if (found != objects_.end()) found->second.access = access;
}

void ObjectDictionary::restore(const ObjectDictionary& defaults, std::uint16_t first, std::uint16_t last) {
  for (auto& [key, object] : objects_) {
    const std::uint32_t index = key >> 8;
    const auto found = defaults.objects_.find(key);
    if (index >= first && index <= last && found != defaults.objects_.end())
      object.value = found->second.value;
  }
}

std::optional<std::uint32_t> ObjectDictionary::refuses_read(can::ObjectAddress address) const {
  if (find(address) != nullptr) return {};
  const auto next = objects_.lower_bound(key({.index = address.index}));
  const bool has_index = next != objects_.end() && next->first >> 8 == address.index;
  return has_index ? can::abort_no_sub_index : can::abort_no_object;
}

std::optional<std::uint32_t> ObjectDictionary::refuses_write(can::ObjectAddress address, std::uint8_t size,
                                                             std::uint32_t value) const {
  const Object* const found = find(address);
  if (found == nullptr) return refuses_read(address);
  const Object& object = *found;
  if (object.access == Access::read_only) return can::abort_read_only;
  if (object.access == Access::write_refused) return can::abort_device_state;
  if (size != 0 && size != object.size) return can::abort_wrong_length;
  if (value > object.max) return can::abort_too_high;
  if (value < object.min) return can::abort_too_low;
  return {};
}

}  // namespace inbetween
