#include <array>
#include <cstdint>

#include "examples/firmware/board.hpp"
#include "examples/firmware/line_sink.hpp"
#include "examples/firmware/table_player.h"

/// A move that was solved elsewhere, on a controller that only plays it: `inbetween plan --trajectory FILE.h`
/// wrote the table, which stays in flash; CMakeLists.txt has it included before all else, since its name is
/// not known here. A press on the button stops it, on its path and inside its limits. The "drives" are the
/// serial port: a line per tick.

bool inbetween::board::program() {
  const inbetween_trajectory& table = INBETWEEN_TABLE;
  constexpr std::size_t max_motors = 64;
  static std::array<double, max_motors> positions;
  static std::array<std::int32_t, max_motors> counts;
  if (table.motor_count > max_motors) {
    send("error: the table has more motors than this program; raise max_motors\n");
    return false;
  }

  inbetween_player player;
  inbetween_start(&player, &table, table.rate_hz);
  LineSink sink;
  start_tick(table.rate_hz);
  std::int64_t next = 0;
  for (bool is_moving = true; is_moving; ++next) {
    const std::int64_t tick = wait_for_tick();
    if (tick != next) {
      send("error: a tick was missed; lower the rate, or make the sink faster\n");
      return false;
    }
    if (button_is_pressed()) inbetween_stop_playing(&player);
    is_moving = inbetween_tick(&player, positions.data()) != 0;
    for (std::size_t m = 0; m < table.motor_count; ++m)
      counts[m] = inbetween_count(&table.motors[m], positions.data());
    sink.set_positions(tick, std::span(counts).first(table.motor_count));
  }
  return true;
}
