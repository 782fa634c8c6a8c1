#include "inbetween/can/bus_load.hpp"

namespace inbetween::can {

Status check_bus_load(const BusUse& use) {
  const bool is_sensible = use.bitrate >= 1 && use.bitrate <= 1'000'000 && use.rate_hz >= 1 &&
                           use.rate_hz <= 10'000 && use.drives >= 1 && use.drives <= 127;
  if (!is_sensible) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "bitrate, rate or number of drives are not those of a CAN bus",
                 .remedy = "use up to 1000000 bit/s, 10000 Hz and 127 drives"};
  }
  const std::int64_t bits = cyclic_bits_per_second(use);
  if (100 * bits > bus_load_limit_percent * use.bitrate) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the setpoints would take more than 70 % of the bus",
                 .remedy = "lower rate_hz, raise the bitrate, or put the drives on several buses",
                 .needed = (100 * bits + bus_load_limit_percent - 1) / bus_load_limit_percent};
  }
  return Done{};
}

}  // namespace inbetween::can
