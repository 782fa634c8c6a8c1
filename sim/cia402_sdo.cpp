// A simulated drive answers requests for its objects, at once or in segments.
#include <algorithm>
#include <utility>

#include "inbetween/can/little_endian.hpp"
#include "inbetween/can/sync.hpp"
#include "sim/cia402_drive.hpp"

namespace inbetween {
namespace {

using can::SdoKind;
using can::SdoMessage;

constexpr std::size_t segment_bytes = 7;

SdoMessage abort_of(can::ObjectAddress object, std::uint32_t code) {
  return {.kind = SdoKind::abort, .object = object, .value = code};
}

std::vector<std::uint8_t> value_of(const SdoMessage& request, std::uint8_t unsaid) {
  std::vector<std::uint8_t> bytes(request.size == 0 ? unsaid : request.size);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(request.value >> (8 * i));
  return bytes;
}

}  // namespace

/// A request that begins a transfer ends the one before it.
void SimulatedCia402Drive::serve(const can::Frame& frame) {
  show();
  const std::optional<SdoMessage> request = can::read_sdo_request(frame);
  if (!request && frame.length != 8) return;
  const bool goes_on =
      request && (request->kind == SdoKind::ask_segment || request->kind == SdoKind::download_segment);
  if (!goes_on) {
    const bool is_silent = request && objects_.is_silent(request->object);
    transfer_.reset();
    if (is_silent || (request && request->kind == SdoKind::abort)) return;
  }
  const SdoMessage unknown = abort_of(
      {.index = can::load<std::uint16_t>(frame.data, 1), .sub = frame.data[3]}, can::abort_unknown_command);
  send(can::sdo_frame(can::sdo_answer_id(node()), request ? answer_to(*request) : unknown));
}

can::SdoMessage SimulatedCia402Drive::answer_to(const SdoMessage& request) {
  switch (request.kind) {
    case SdoKind::upload:
      return begin_upload(request.object);
    case SdoKind::download: {
      const auto* const asked = objects_.find(request.object);
      return take(request.object, value_of(request, asked == nullptr ? std::uint8_t{4} : asked->size));
    }
    case SdoKind::announce_download:
      if (const auto why = objects_.refuses_length(request.object, request.value)) {
        return abort_of(request.object, *why);
      }
      transfer_ = Transfer{.object = request.object, .announced = request.value};
      return {.kind = SdoKind::download_done, .object = request.object};
    default:
      break;
  }
  const bool is_download = request.kind == SdoKind::download_segment;
  if (!transfer_ || (transfer_->announced != 0) != is_download) {
    transfer_.reset();
    return abort_of({}, can::abort_unknown_command);
  }
  const can::ObjectAddress object = transfer_->object;
  if (request.toggle != transfer_->toggle) {
    transfer_.reset();
    return abort_of(object, can::abort_toggle);
  }
  transfer_->toggle = !transfer_->toggle;
  return is_download ? take_segment(request) : next_segment();
}

can::SdoMessage SimulatedCia402Drive::begin_upload(can::ObjectAddress object) {
  show();
  if (const auto why = objects_.refuses_read(object)) return abort_of(object, *why);
  std::vector<std::uint8_t> bytes = objects_.read(object);
  const auto size = static_cast<std::uint32_t>(bytes.size());
  if (objects_.find(object)->bytes.empty()) {
    return {.kind = SdoKind::upload_value,
            .object = object,
            .size = static_cast<std::uint8_t>(size),
            .value = objects_.find(object)->value};
  }
  transfer_ = Transfer{.object = object, .bytes = std::move(bytes)};
  return {.kind = SdoKind::announce_upload, .object = object, .value = size};
}

can::SdoMessage SimulatedCia402Drive::next_segment() {
  const std::vector<std::uint8_t>& bytes = transfer_->bytes;
  const std::size_t size = std::min(segment_bytes, bytes.size() - transfer_->at);
  SdoMessage segment{.kind = SdoKind::upload_segment,
                     .size = static_cast<std::uint8_t>(size),
                     .toggle = !transfer_->toggle,
                     .is_last = transfer_->at + size == bytes.size()};
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(transfer_->at), size, segment.segment.begin());
  transfer_->at += size;
  if (segment.is_last) transfer_.reset();
  return segment;
}

can::SdoMessage SimulatedCia402Drive::take_segment(const SdoMessage& request) {
  std::vector<std::uint8_t>& bytes = transfer_->bytes;
  bytes.insert(bytes.end(), request.segment.begin(), request.segment.begin() + request.size);
  const bool is_whole = bytes.size() == transfer_->announced;
  if (bytes.size() > transfer_->announced || (request.is_last && !is_whole)) {
    const can::ObjectAddress object = transfer_->object;
    transfer_.reset();
    return abort_of(object, can::abort_wrong_length);
  }
  const SdoMessage done{.kind = SdoKind::download_segment_done, .toggle = request.toggle};
  if (!request.is_last) return done;
  const Transfer ended = std::move(*transfer_);
  transfer_.reset();
  const SdoMessage answer = take(ended.object, ended.bytes);
  return answer.kind == SdoKind::abort ? answer : done;
}

/// A value that is there as a whole.
can::SdoMessage SimulatedCia402Drive::take(can::ObjectAddress object,
                                           const std::vector<std::uint8_t>& bytes) {
  if (const auto why = refuses_download(object, bytes)) return abort_of(object, *why);
  objects_.write(object, bytes);
  note_written(object);
  return {.kind = SdoKind::download_done, .object = object};
}

std::optional<std::uint32_t> SimulatedCia402Drive::refuses_download(
    can::ObjectAddress object, const std::vector<std::uint8_t>& bytes) const {
  if (const auto why = objects_.refuses_write(object, bytes)) return why;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 4); ++i)
    value |= std::uint32_t{bytes[i]} << (8 * i);
  if (object.index == 0x1019) {
    if (objects_.value(0x1006) != 0) return can::abort_device_state;
    if (!can::is_sync_overflow(static_cast<std::uint8_t>(value))) return can::abort_bad_value;
  }
  if (object.index == 0x6060) {
    const bool has_list = objects_.find({.index = 0x6502}) != nullptr;
    const std::uint32_t offered = has_list ? objects_.value(0x6502) : 0xFFFFFFFF;
    const bool is_known = value >= 1 && value <= 32 && ((offered >> (value - 1)) & 1) != 0;
    if (!is_known) return can::abort_bad_value;
  }
  return refuses_pdo(object, value);
}

}  // namespace inbetween
