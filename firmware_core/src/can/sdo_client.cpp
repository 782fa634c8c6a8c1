#include "inbetween/can/sdo_client.hpp"

#include <array>

namespace inbetween::can {
namespace {

using enum SdoState;

constexpr std::array<std::array<SdoState, sdo_events>, sdo_states> table{{
    // begin, poll, deadline, answer, refusal, nonsense, other
    {queued, idle, idle, idle, idle, idle, idle},                          // idle
    {queued, waiting, queued, queued, queued, queued, queued},             // queued
    {waiting, waiting, aborting, done, failed, aborting, waiting},         // waiting
    {aborting, failed, aborting, aborting, aborting, aborting, aborting},  // aborting
    {queued, done, done, done, done, done, done},                          // done
    {queued, failed, failed, failed, failed, failed, failed},              // failed
}};

/// Whether an answer is of the kind that the request asks for.
bool is_answer_to(const SdoMessage& request, std::uint8_t size, const SdoMessage& answer) {
  if (request.kind == SdoKind::download) return answer.kind == SdoKind::download_done;
  return answer.kind == SdoKind::upload_value && (answer.size == 0 || answer.size == size);
}

}  // namespace

SdoState next_state(SdoState state, SdoEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

bool SdoClient::begin_upload(ObjectAddress object, std::uint8_t size) {
  return begin({.kind = SdoKind::upload, .object = object}, size);
}

bool SdoClient::begin_download(ObjectAddress object, std::uint8_t size, std::uint32_t value) {
  return begin({.kind = SdoKind::download, .object = object, .size = size, .value = value}, size);
}

bool SdoClient::begin(const SdoMessage& request, std::uint8_t size) {
  const bool is_free = state_ == idle || state_ == done || state_ == failed;
  if (!is_free || size < 1 || size > 4) return false;
  state_ = next_state(state_, SdoEvent::begin);
  request_ = request;
  size_ = size;
  value_ = 0;
  abort_code_ = 0;
  return true;
}

std::optional<Frame> SdoClient::poll(std::int64_t now_ns) {
  if (state_ == waiting && now_ns >= deadline_ns_) {
    state_ = next_state(state_, SdoEvent::deadline);
    abort_code_ = abort_timeout;
  }
  const SdoState before = state_;
  state_ = next_state(state_, SdoEvent::poll);
  if (before == queued) {
    deadline_ns_ = now_ns + timeout_ns_;
    return sdo_frame(sdo_request_id(node_), request_);
  }
  if (before == aborting) {
    return sdo_frame(sdo_request_id(node_),
                     {.kind = SdoKind::abort, .object = request_.object, .value = abort_code_});
  }
  return {};
}

SdoEvent SdoClient::event_of(const std::optional<SdoMessage>& answer) const {
  if (!answer) return SdoEvent::other;
  const bool names_object =
      answer->kind != SdoKind::upload_segment && answer->kind != SdoKind::download_segment_done;
  if (names_object && answer->object != request_.object) return SdoEvent::other;
  if (answer->kind == SdoKind::abort) return SdoEvent::refusal;
  return is_answer_to(request_, size_, *answer) ? SdoEvent::answer : SdoEvent::nonsense;
}

bool SdoClient::receive(const Frame& frame) {
  if (state_ != waiting) return false;
  const std::optional<SdoMessage> answer = read_sdo_answer(frame);
  const SdoEvent event = event_of(answer);
  state_ = next_state(state_, event);
  switch (event) {
    case SdoEvent::answer:
      value_ = answer->value & (0xFFFFFFFFU >> (8U * (4U - size_)));
      return true;
    case SdoEvent::refusal:
      abort_code_ = answer->value;
      return true;
    case SdoEvent::nonsense:
      abort_code_ = abort_unknown_command;
      return false;
    default:
      return false;
  }
}

}  // namespace inbetween::can
