/* Plays a whole table as a controller would: a line a tick, "COUNT... POSITION...", of every motor and every position.
 * With an argument the button is pressed on that tick.
 *
 *   cc -std=c99 -Wall -Wextra -Werror -ffp-contract=off -include move.h -D TABLE=move_table play_all.c -lm */
#include "examples/firmware/table_player.h"

#include <stdio.h>
#include <stdlib.h>

int main(int argc, char** argv) {
  static double positions[64];
  const long long press = argc > 1 ? atoll(argv[1]) : -1;
  inbetween_player player;
  inbetween_start(&player, &TABLE, TABLE.rate_hz);
  int is_moving = 1;
  for (long long tick = 0; is_moving; ++tick) {
    if (tick == press) inbetween_stop_playing(&player);
    is_moving = inbetween_tick(&player, positions);
    for (uint32_t m = 0; m < TABLE.motor_count; ++m) printf("%ld ", (long)inbetween_count(&TABLE.motors[m], positions));
    for (uint32_t i = 0; i < TABLE.position_count; ++i) printf("%.17g ", positions[i]);
    printf("\n");
  }
  return 0;
}
