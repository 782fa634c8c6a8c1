#include "inbetween/can/sdo_client.hpp"

#include <algorithm>

namespace inbetween::can {
namespace {

using enum SdoState;

constexpr std::array<std::array<SdoState, sdo_events>, sdo_states> table{{
    // begin, poll, deadline, answer, more, refusal, nonsense, other
    {queued, idle, idle, idle, idle, idle, idle, idle},                              // idle
    {queued, waiting, queued, queued, queued, queued, queued, queued},               // queued
    {waiting, waiting, aborting, done, queued, failed, aborting, waiting},           // waiting
    {aborting, failed, aborting, aborting, aborting, aborting, aborting, aborting},  // aborting
    {queued, done, done, done, done, done, done, done},                              // done
    {queued, failed, failed, failed, failed, failed, failed, failed},                // failed
}};

constexpr std::size_t segment_bytes = 7;

constexpr std::uint32_t low_bytes(std::size_t count) {
  return 0xFFFFFFFFU >> (8U * (4U - count));
}

/// Whether the bytes above the lowest `size` say nothing: they are 0, or the sign.
constexpr bool fits(std::uint32_t value, std::size_t told, std::size_t size) {
  const std::uint32_t above = low_bytes(told) & ~low_bytes(size);
  const bool is_negative = ((value >> (8U * size - 1)) & 1U) != 0;
  return (value & above) == 0 || (is_negative && (value & above) == above);
}

constexpr bool names_object(SdoKind kind) {
  return kind != SdoKind::upload_segment && kind != SdoKind::download_segment_done;
}

}  // namespace

SdoState next_state(SdoState state, SdoEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

bool SdoClient::begin_upload(ObjectAddress object, std::uint8_t size) {
  if (size < 1 || size > 4) return false;
  return begin({.kind = SdoKind::upload, .object = object}, size);
}

bool SdoClient::begin_download(ObjectAddress object, std::uint8_t size, std::uint32_t value) {
  if (size < 1 || size > 4) return false;
  return begin({.kind = SdoKind::download, .object = object, .size = size, .value = value}, size);
}

bool SdoClient::begin_upload(ObjectAddress object, std::span<std::uint8_t> storage) {
  if (storage.empty() || !begin({.kind = SdoKind::upload, .object = object}, 0)) return false;
  storage_ = storage;
  return true;
}

bool SdoClient::begin_download(ObjectAddress object, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return false;
  if (bytes.size() <= 4) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint32_t{bytes[i]} << (8 * i);
    return begin_download(object, static_cast<std::uint8_t>(bytes.size()), value);
  }
  const auto size = static_cast<std::uint32_t>(bytes.size());
  if (!begin({.kind = SdoKind::announce_download, .object = object, .value = size}, 0)) return false;
  to_send_ = bytes;
  return true;
}

bool SdoClient::begin(const SdoMessage& request, std::uint8_t size) {
  const bool is_free = state_ == idle || state_ == done || state_ == failed;
  if (!is_free) return false;
  state_ = next_state(state_, SdoEvent::begin);
  request_ = request;
  object_ = request.object;
  storage_ = {};
  to_send_ = {};
  size_ = size;
  has_given_up_ = false;
  announced_ = 0;
  length_ = 0;
  value_ = 0;
  abort_code_ = 0;
  return true;
}

std::optional<Frame> SdoClient::poll(std::int64_t now_ns) {
  if (state_ == waiting && now_ns >= deadline_ns_) {
    give_up(abort_timeout);
    state_ = next_state(state_, SdoEvent::deadline);
  }
  const SdoState before = state_;
  state_ = next_state(state_, SdoEvent::poll);
  if (before == queued) {
    deadline_ns_ = now_ns + timeout_ns_;
    return sdo_frame(sdo_request_id(node_), request_);
  }
  if (before == aborting) {
    return sdo_frame(sdo_request_id(node_),
                     {.kind = SdoKind::abort, .object = object_, .value = abort_code_});
  }
  return {};
}

bool SdoClient::receive(const Frame& frame) {
  if (state_ != waiting) return false;
  const std::optional<SdoMessage> answer = read_sdo_answer(frame);
  SdoEvent event = answer ? take(*answer) : SdoEvent::other;
  // On CAN a frame may come twice: the last answer again does no harm.
  if (event == SdoEvent::nonsense && frame == last_) {
    has_given_up_ = false;
    abort_code_ = 0;
    event = SdoEvent::other;
  }
  state_ = next_state(state_, event);
  const bool is_awaited = event == SdoEvent::answer || event == SdoEvent::more || event == SdoEvent::refusal;
  if (is_awaited) last_ = frame;
  return is_awaited;
}

SdoEvent SdoClient::give_up(std::uint32_t abort_code) {
  abort_code_ = abort_code;
  has_given_up_ = true;
  return SdoEvent::nonsense;
}

SdoEvent SdoClient::take(const SdoMessage& answer) {
  if (names_object(answer.kind) && answer.object != object_) return SdoEvent::other;
  if (answer.kind == SdoKind::abort) {
    abort_code_ = answer.value;
    return SdoEvent::refusal;
  }
  const bool is_in_segments =
      request_.kind == SdoKind::ask_segment || request_.kind == SdoKind::download_segment;
  if (!names_object(answer.kind) && !is_in_segments) return SdoEvent::other;  // of a transfer that has ended
  switch (request_.kind) {
    case SdoKind::download:
      if (answer.kind == SdoKind::download_done) return SdoEvent::answer;
      break;
    case SdoKind::announce_download:
      if (answer.kind == SdoKind::download_done) return send_next_segment(false);
      break;
    case SdoKind::download_segment:
      if (answer.kind != SdoKind::download_segment_done) break;
      if (answer.toggle != request_.toggle) return give_up(abort_toggle);
      return request_.is_last ? SdoEvent::answer : send_next_segment(!request_.toggle);
    case SdoKind::upload:
      if (answer.kind == SdoKind::upload_value) return take_value(answer);
      if (answer.kind == SdoKind::announce_upload) return take_announcement(answer);
      break;
    case SdoKind::ask_segment:
      if (answer.kind == SdoKind::upload_segment) return take_segment(answer);
      break;
    default:
      break;
  }
  return give_up(abort_unknown_command);
}

SdoEvent SdoClient::take_value(const SdoMessage& answer) {
  // Where the device does not tell how many bytes count, a number has those that it shall have.
  const std::size_t unsaid = size_ == 0 ? 4 : size_;
  const std::size_t told = answer.size == 0 ? unsaid : answer.size;
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t i = 0; i < told; ++i) bytes[i] = static_cast<std::uint8_t>(answer.value >> (8 * i));
  if (!append(bytes.data(), told)) return give_up(abort_out_of_memory);
  return has_read_all();
}

SdoEvent SdoClient::take_announcement(const SdoMessage& answer) {
  announced_ = answer.value;
  if (announced_ > room()) return give_up(abort_out_of_memory);
  return ask_next_segment(false);
}

SdoEvent SdoClient::take_segment(const SdoMessage& answer) {
  if (answer.toggle != request_.toggle) return give_up(abort_toggle);
  if (answer.size == 0 && !answer.is_last) return give_up(abort_wrong_length);
  if (!append(answer.segment.data(), answer.size)) return give_up(abort_out_of_memory);
  if (!answer.is_last) return ask_next_segment(!request_.toggle);
  return length_ == announced_ ? has_read_all() : give_up(abort_wrong_length);
}

SdoEvent SdoClient::has_read_all() {
  if (size_ == 0) return SdoEvent::answer;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < length_; ++i) value |= std::uint32_t{number_[i]} << (8 * i);
  if (length_ < size_ || !fits(value, length_, size_)) return give_up(abort_wrong_length);
  value_ = value & low_bytes(size_);
  return SdoEvent::answer;
}

SdoEvent SdoClient::ask_next_segment(bool toggle) {
  request_ = {.kind = SdoKind::ask_segment, .toggle = toggle};
  return SdoEvent::more;
}

SdoEvent SdoClient::send_next_segment(bool toggle) {
  const std::size_t count = std::min(segment_bytes, to_send_.size());
  request_ = {.kind = SdoKind::download_segment,
              .size = static_cast<std::uint8_t>(count),
              .toggle = toggle,
              .is_last = count == to_send_.size()};
  std::copy_n(to_send_.begin(), count, request_.segment.begin());
  to_send_ = to_send_.subspan(count);
  return SdoEvent::more;
}

bool SdoClient::append(const std::uint8_t* bytes, std::size_t count) {
  if (length_ + count > room()) return false;
  std::copy_n(bytes, count, (storage_.empty() ? number_.data() : storage_.data()) + length_);
  length_ += count;
  return true;
}

}  // namespace inbetween::can
