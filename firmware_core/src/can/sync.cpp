#include "inbetween/can/sync.hpp"

#include "inbetween/can/canopen_id.hpp"

namespace inbetween::can {

Result<SyncProducer> SyncProducer::make(std::uint8_t overflow) {
  if (!is_sync_overflow(overflow)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the counter of SYNC cannot end at this number",
                 .remedy = "use 0 for no counter, or 2 to 240"};
  }
  return SyncProducer(overflow);
}

Frame SyncProducer::next() {
  if (overflow_ == 0) return {.id = sync_id};
  last_ = last_ >= overflow_ ? std::uint8_t{1} : static_cast<std::uint8_t>(last_ + 1);
  return {.id = sync_id, .length = 1, .data = {last_}};
}

}  // namespace inbetween::can
