/* Plays a table that `inbetween plan --trajectory move.h` wrote: C99 and C++, no heap, no library but floor().
 *
 *   #include "move.h"
 *   #include "table_player.h"
 *
 *   inbetween_player player;
 *   inbetween_start(&player, &move_table, 1000);
 *   every 1/1000 s:
 *     if (button) inbetween_stop_playing(&player);
 *     inbetween_tick(&player, positions);
 *     for each motor m: send inbetween_count(&move_table.motors[m], positions);
 *
 * Compile without contraction (gcc, clang: -ffp-contract=off), and positions have the same bits on every processor:
 * those of `inbetween plan --per tick` but for some 1e-15 of the way of a piece, and the counts are those of
 * `inbetween run`.
 *
 * Nothing here knows whether the rig stands where the move begins, homes it or looks after the drives. */
#ifndef INBETWEEN_TABLE_PLAYER
#define INBETWEEN_TABLE_PLAYER

#include <math.h>
#include <stdint.h>

#if INBETWEEN_TRAJECTORY != 1
#error "include a table before this, one that this player knows: INBETWEEN_TRAJECTORY is to be 1"
#endif
#ifdef __cplusplus
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif

/* A place on the time line: a whole frame and a part of one, 0 to below 1. A long move so keeps its digits. */
typedef struct inbetween_place {
  int32_t frame;
  double fraction;
} inbetween_place;

typedef struct inbetween_player {
  const inbetween_trajectory* table;
  int32_t rate_hz;
  /* The place of the tick, exactly: `frame`, and `rest` / `unit` of one. */
  int32_t frame;
  int64_t rest;
  int64_t unit;
  /* A stop, once it has begun: where, and how many ticks ago. */
  const inbetween_stop* stop;
  inbetween_place stop_from;
  int64_t stop_ticks;
} inbetween_player;

/* Before the first tick. `rate_hz` need not be that of the rig: a move has the same speed at every rate. */
static inline void inbetween_start(inbetween_player* player, const inbetween_trajectory* table, int32_t rate_hz) {
  player->table = table;
  player->rate_hz = rate_hz;
  player->frame = table->first_frame;
  player->rest = 0;
  player->unit = (int64_t)rate_hz * table->fps_denominator;
  player->stop = 0;
  player->stop_ticks = 0;
}

static inline inbetween_place inbetween_moved_by(inbetween_place from, double frames) {
  const double sum = from.fraction + frames;
  const double whole = floor(sum);
  inbetween_place place;
  place.frame = from.frame + (int32_t)whole;
  place.fraction = sum - whole;
  return place;
}

/* The seconds of the move that pass in `t` seconds of a stop. The rate of time is 1 at first; its change grows to
 * `change` in jerk_s, stays for steady_s and goes back to 0. */
static inline double inbetween_stop_way(const inbetween_stop* stop, double t) {
  const double change = 1 / (stop->jerk_s + stop->steady_s);
  const double jerk = change / stop->jerk_s;
  const double seconds = 2 * stop->jerk_s + stop->steady_s;
  const double left = seconds - t;
  if (left <= 0) return seconds / 2;
  if (left < stop->jerk_s) return seconds / 2 - jerk * left * left * left / 6;
  if (t < stop->jerk_s) return t - jerk * t * t * t / 6;
  t -= stop->jerk_s;
  return stop->jerk_s - change * stop->jerk_s * stop->jerk_s / 6 + (1 - change * stop->jerk_s / 2) * t -
         change * t * t / 2;
}

/* Where the tick is on the time line. */
static inline inbetween_place inbetween_place_of(const inbetween_player* player) {
  const inbetween_trajectory* const table = player->table;
  if (player->stop) {
    const double way = inbetween_stop_way(player->stop, (double)player->stop_ticks / player->rate_hz);
    return inbetween_moved_by(player->stop_from, way * table->fps_numerator / table->fps_denominator);
  }
  inbetween_place place;
  place.frame = player->frame;
  place.fraction = (double)player->rest / (double)player->unit;
  return place;
}

/* From this tick on: the stop of the table that begins here. It stays on the path, and inside the limits for which
 * the table was made. Nothing takes it back. */
static inline void inbetween_stop_playing(inbetween_player* player) {
  const inbetween_trajectory* const table = player->table;
  if (player->stop) return;
  player->stop_from = inbetween_place_of(player);
  const double frames = (player->stop_from.frame - table->first_frame) + player->stop_from.fraction;
  const double share = frames / (table->last_frame - table->first_frame);
  const double cell = share * table->stop_count;
  player->stop = &table->stops[cell < table->stop_count ? (uint32_t)cell : table->stop_count - 1];
}

static inline int inbetween_is_before(int32_t frame, double fraction, inbetween_place place) {
  return frame < place.frame || (frame == place.frame && fraction <= place.fraction);
}

/* The positions of a group at a place: the last piece that has begun, by Horner's rule. O(log pieces). */
static inline void inbetween_group_positions(const inbetween_group* group, inbetween_place place, double* positions) {
  uint32_t begin = 0;
  uint32_t end = group->piece_count;
  while (end - begin > 1) {
    const uint32_t middle = begin + (end - begin) / 2;
    if (inbetween_is_before(group->pieces[middle].frame, group->pieces[middle].fraction, place)) {
      begin = middle;
    } else {
      end = middle;
    }
  }
  const inbetween_piece* const piece = &group->pieces[begin];
  const double u = ((place.frame - piece->frame) + (place.fraction - piece->fraction)) * piece->per_frame;
  const double* c = &group->coefficients[piece->first];
  for (uint32_t i = 0; i < group->position_count; ++i, c += piece->degree + 1) {
    double sum = c[piece->degree];
    for (int32_t power = piece->degree - 1; power >= 0; --power) sum = sum * u + c[power];
    positions[group->positions[i]] = sum;
  }
}

/* Writes the positions of this tick, position_count of them, and goes on to the next one. Returns 1 while something
 * may still move, and 0 once all rests, at the end or stopped; from then on positions stay what they are. */
static inline int inbetween_tick(inbetween_player* player, double* positions) {
  const inbetween_trajectory* const table = player->table;
  const inbetween_place place = inbetween_place_of(player);
  const int is_over = place.frame >= table->last_frame;
  for (uint32_t g = 0; g < table->group_count; ++g) {
    const inbetween_group* const group = &table->groups[g];
    if (is_over) {
      for (uint32_t i = 0; i < group->position_count; ++i) positions[group->positions[i]] = group->end[i];
    } else {
      inbetween_group_positions(group, place, positions);
    }
  }
  if (player->stop) {
    const double seconds = 2 * player->stop->jerk_s + player->stop->steady_s;
    if (is_over || (double)player->stop_ticks >= seconds * player->rate_hz) return 0;
    ++player->stop_ticks;
    return 1;
  }
  if (is_over) return 0;
  player->rest += table->fps_numerator;
  for (; player->rest >= player->unit; player->rest -= player->unit) ++player->frame;
  return 1;
}

/* What a motor is sent, in units of its drive. */
static inline double inbetween_drive_position(const inbetween_motor* motor, const double* positions) {
  return (positions[motor->position] + motor->offset) * motor->scale + motor->zero;
}

/* The same of a drive that counts whole numbers. */
static inline int32_t inbetween_count(const inbetween_motor* motor, const double* positions) {
  return (int32_t)floor(inbetween_drive_position(motor, positions) + 0.5);
}

#ifdef __cplusplus
#pragma GCC diagnostic pop
#endif
#endif
