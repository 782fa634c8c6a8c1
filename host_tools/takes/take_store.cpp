#include "host_tools/takes/take_store.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "host_tools/takes/byte_text.hpp"
#include "host_tools/takes/database_file.hpp"
#include "host_tools/takes/take_database.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/tick_codec.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// "ibtw"
constexpr std::int64_t application_id = 0x69627477;
constexpr std::int64_t newest_version = 1;
constexpr std::int64_t all_chunks = std::numeric_limits<std::int64_t>::max();

constexpr const char* tables = R"(
CREATE TABLE content (hash TEXT PRIMARY KEY, bytes BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE take (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  move_name TEXT NOT NULL, rig_name TEXT NOT NULL,
  started_at TEXT NOT NULL, version TEXT NOT NULL, ending TEXT NOT NULL DEFAULT '',
  is_simulated INTEGER NOT NULL, is_whole INTEGER NOT NULL DEFAULT 0, is_marked INTEGER NOT NULL DEFAULT 0,
  is_going INTEGER NOT NULL DEFAULT 0,
  rate_hz INTEGER NOT NULL, fps_numerator INTEGER NOT NULL, fps_denominator INTEGER NOT NULL,
  frames INTEGER NOT NULL, first_frame INTEGER NOT NULL, last_frame INTEGER NOT NULL,
  turns INTEGER NOT NULL, is_repeated INTEGER NOT NULL, is_shot INTEGER NOT NULL, top_rate REAL NOT NULL,
  trajectory TEXT NOT NULL REFERENCES content (hash),
  ticks INTEGER NOT NULL DEFAULT 0, lost_ticks INTEGER NOT NULL DEFAULT 0, bytes INTEGER NOT NULL DEFAULT 0);
CREATE TABLE axis (
  take INTEGER NOT NULL REFERENCES take ON DELETE CASCADE, number INTEGER NOT NULL,
  name TEXT NOT NULL, unit TEXT NOT NULL, resolution REAL NOT NULL, move_axis INTEGER,
  PRIMARY KEY (take, number)) WITHOUT ROWID;
CREATE TABLE file (
  take INTEGER NOT NULL REFERENCES take ON DELETE CASCADE, number INTEGER NOT NULL,
  role INTEGER NOT NULL, path TEXT NOT NULL, hash TEXT NOT NULL REFERENCES content (hash),
  PRIMARY KEY (take, number)) WITHOUT ROWID;
CREATE TABLE chunk (
  take INTEGER NOT NULL REFERENCES take ON DELETE CASCADE,
  first_tick INTEGER NOT NULL, ticks INTEGER NOT NULL, bytes BLOB NOT NULL,
  UNIQUE (take, first_tick));
CREATE TABLE event (
  take INTEGER NOT NULL REFERENCES take ON DELETE CASCADE,
  tick INTEGER NOT NULL, kind INTEGER NOT NULL, text TEXT NOT NULL);
CREATE INDEX event_of_take ON event (take, tick);
CREATE INDEX file_of_content ON file (hash);
CREATE INDEX take_of_content ON take (trajectory);
)";

constexpr const char* info_columns =
    "number, move_name, rig_name, started_at, version, ending, is_simulated, is_whole, is_marked, rate_hz, "
    "fps_numerator, fps_denominator, frames, first_frame, last_frame, turns, is_repeated, is_shot, top_rate, "
    "ticks, lost_ticks, bytes";

}  // namespace

// --- the file

TakeStore::TakeStore(const std::string& file, Access access) : database_(file) {
  open(access);
}

void TakeStore::open(Access access) {
  std::error_code unknown;
  if (access == Access::read && !std::filesystem::exists(file(), unknown)) {
    database_.fail("there are no takes",
                   "inbetween run keeps them in the folder of the move; name another with --in");
  }
  const int how = access == Access::read ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  database_.open(address_of_database(file()), how);
  if (access == Access::read && lacks_its_index()) open_write_protected();
  database_.execute("PRAGMA foreign_keys = ON");
  const std::int64_t id = database_.number_of("PRAGMA application_id");
  const std::int64_t version = database_.number_of("PRAGMA user_version");
  const bool is_new = database_.number_of("SELECT count(*) FROM sqlite_schema") == 0 && id == 0;
  if (!is_new && id != application_id) database_.fail("this is no file of takes", "name another file");
  if (version > newest_version)
    database_.fail(fmt::format("it is of version {}, and this program knows {}", version, newest_version),
                   "use a newer inbetween, or another file");
  if (access == Access::read && is_new)
    database_.fail("there are no takes in it", "inbetween run keeps them");
  if (access == Access::read) return;
  if (database_.is_write_protected())
    database_.fail("it is write-protected",
                   "choose a file that you may write to with --takes-in FILE, or --no-take");
  if (is_new) make_tables();
  database_.execute("PRAGMA journal_mode = WAL");
  database_.execute("PRAGMA synchronous = NORMAL");
  // Where somebody reads for long the log grows beyond; then it is cut off again.
  database_.execute("PRAGMA journal_size_limit = 4000000");
}

/// Whoever reads a file with a write-ahead log needs its index, FILE-shm, and makes one where there is none:
/// not where the folder is write-protected.
bool TakeStore::lacks_its_index() {
  if (!refusal_beside(file())) return false;
  const int code = database_.attempt("SELECT 1 FROM sqlite_schema") & 0xFF;
  return code == SQLITE_CANTOPEN || code == SQLITE_READONLY;
}

/// Nobody has the file open, or it would have its index. So nobody writes, and without a log the file can be
/// read as it is ("Write-Ahead Logging: Read-Only Databases" of SQLite's documents). Immutable, SQLite would
/// not see what is in a log alone: then it reads a copy, which can have an index. A change in the copy would
/// be lost.
void TakeStore::open_write_protected() {
  if (!has_database_log(file())) {
    database_.open(address_of_database(file()) + "?immutable=1", SQLITE_OPEN_READONLY);
    return;
  }
  std::unique_ptr<DatabaseCopy> copy;
  try {
    copy = std::make_unique<DatabaseCopy>(file());
  } catch (const std::system_error& error) {
    database_.fail(
        fmt::format("it is write-protected, and it takes a copy to read what is in its log alone: {}",
                    error.code().message()),
        "make room for temporary files, or name a folder for them in TMPDIR");
  }
  database_.open_copy(std::move(copy));
  database_.execute("PRAGMA query_only = ON");
}

/// Two programs may come here at once.
void TakeStore::make_tables() {
  database_.execute("PRAGMA auto_vacuum = INCREMENTAL");
  database_.execute("PRAGMA journal_mode = WAL");
  Transaction transaction(database_);
  if (database_.number_of("PRAGMA application_id") == 0) {
    database_.execute(tables);
    database_.execute(fmt::format("PRAGMA application_id = {}", application_id).c_str());
    database_.execute(fmt::format("PRAGMA user_version = {}", newest_version).c_str());
  }
  transaction.commit();
}

// --- writing a take

/// What several takes have the same is kept once.
std::string TakeStore::keep_content(const std::string& bytes) {
  std::string hash = hash_of_content(bytes);
  Statement(database_, "INSERT OR IGNORE INTO content VALUES (?, ?)").with(hash).with_bytes(bytes).run();
  return hash;
}

/// Its axes and files.
void TakeStore::keep_parts(std::int64_t number, const Take& take) {
  std::int32_t row = 0;
  for (const TakeAxis& axis : take.axes) {
    Statement(database_, "INSERT INTO axis VALUES (?, ?, ?, ?, ?, ?)")
        .with(number)
        .with(row++)
        .with(axis.name)
        .with(axis.unit)
        .with(axis.resolution)
        .with(axis.move_axis)
        .run();
  }
  row = 0;
  for (const TakeFile& file : take.files) {
    Statement(database_, "INSERT INTO file VALUES (?, ?, ?, ?, ?)")
        .with(number)
        .with(row++)
        .with(static_cast<std::int32_t>(file.role))
        .with(file.path)
        .with(keep_content(file.text))
        .run();
  }
}

std::int64_t TakeStore::begin(const Take& take) {
  Transaction transaction(database_);
  std::int64_t bytes = static_cast<std::int64_t>(take.trajectory.size());
  for (const TakeFile& file : take.files) bytes += static_cast<std::int64_t>(file.text.size());
  Statement(database_,
            "INSERT INTO take (move_name, rig_name, started_at, version, is_simulated, rate_hz, "
            "fps_numerator, fps_denominator, frames, first_frame, last_frame, turns, is_repeated, is_shot, "
            "top_rate, trajectory, bytes) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .with(take.move_name)
      .with(take.rig_name)
      .with(take.started_at)
      .with(take.version)
      .with(take.is_simulated)
      .with(take.rate_hz)
      .with(take.frame_rate.numerator)
      .with(take.frame_rate.denominator)
      .with(take.frames)
      .with(take.part.first)
      .with(take.part.last)
      .with(take.turns)
      .with(take.is_repeated)
      .with(take.is_shot)
      .with(take.top_rate)
      .with(keep_content(take.trajectory))
      .with(bytes)
      .run();
  const std::int64_t number = database_.last_row();
  keep_parts(number, take);
  transaction.commit();
  return number;
}

void TakeStore::append(std::int64_t take, const TakeChunk& chunk, const std::vector<TakeEvent>& events,
                       std::int64_t lost_ticks) {
  Transaction transaction(database_);
  auto bytes = static_cast<std::int64_t>(chunk.bytes.size());
  if (chunk.ticks > 0) {
    Statement(database_, "INSERT INTO chunk VALUES (?, ?, ?, ?)")
        .with(take)
        .with(chunk.first)
        .with(chunk.ticks)
        .with_bytes(chunk.bytes)
        .run();
  }
  for (const TakeEvent& event : events) {
    Statement(database_, "INSERT INTO event VALUES (?, ?, ?, ?)")
        .with(take)
        .with(event.tick)
        .with(static_cast<std::int32_t>(event.kind))
        .with(event.text)
        .run();
    bytes += static_cast<std::int64_t>(event.text.size());
  }
  Statement(database_,
            "UPDATE take SET ticks = ticks + ?, lost_ticks = ?, bytes = bytes + ? WHERE number = ?")
      .with(chunk.ticks)
      .with(lost_ticks)
      .with(bytes)
      .with(take)
      .run();
  transaction.commit();
}

void TakeStore::finish(std::int64_t take, const std::string& ending, bool is_whole, std::int64_t lost_ticks) {
  database_.execute("PRAGMA synchronous = FULL");
  Transaction transaction(database_);
  Statement(database_, "UPDATE take SET ending = ?, is_whole = ?, lost_ticks = ? WHERE number = ?")
      .with(ending)
      .with(is_whole)
      .with(lost_ticks)
      .with(take)
      .run();
  transaction.commit();
  database_.execute("PRAGMA synchronous = NORMAL");
}

// --- reading

namespace {

template <class Row>
void read_info(Row& row, TakeInfo& info) {
  info.number = row.number();
  info.move_name = row.text();
  info.rig_name = row.text();
  info.started_at = row.text();
  info.version = row.text();
  info.ending = row.text();
  info.is_simulated = row.truth();
  info.is_whole = row.truth();
  info.is_marked = row.truth();
  info.rate_hz = row.small();
  info.frame_rate.numerator = row.small();
  info.frame_rate.denominator = row.small();
  info.frames = row.small();
  info.part.first = row.small();
  info.part.last = row.small();
  info.turns = row.small();
  info.is_repeated = row.truth();
  info.is_shot = row.truth();
  info.top_rate = row.real();
  info.ticks = row.number();
  info.lost_ticks = row.number();
  info.bytes = row.number();
}

}  // namespace

std::vector<TakeInfo> TakeStore::list() {
  std::vector<TakeInfo> all;
  Statement rows(database_,
                 fmt::format("SELECT {} FROM take WHERE is_going = 0 ORDER BY number", info_columns));
  while (rows.next()) read_info(rows, all.emplace_back());
  return all;
}

void TakeStore::refuse_unknown(std::int64_t take) {
  Statement there(database_, "SELECT 1 FROM take WHERE number = ? AND is_going = 0");
  if (!there.with(take).next())
    database_.fail(fmt::format("there is no take {}", take), "inbetween takes list shows all");
}

Take TakeStore::read_head(std::int64_t number) {
  refuse_unknown(number);
  Take take;
  Statement row(database_,
                fmt::format("SELECT {}, (SELECT bytes FROM content WHERE hash = trajectory) FROM take "
                            "WHERE number = ?",
                            info_columns));
  if (row.with(number).next()) {
    read_info(row, take);
    take.trajectory = row.text();
  }
  Statement axes(database_,
                 "SELECT name, unit, resolution, move_axis FROM axis WHERE take = ? ORDER BY number");
  axes.with(number);
  while (axes.next()) {
    TakeAxis& axis = take.axes.emplace_back();
    axis.name = axes.text();
    axis.unit = axes.text();
    axis.resolution = axes.real();
    axis.move_axis = axes.maybe();
  }
  Statement files(
      database_,
      "SELECT role, path, hash, bytes FROM file JOIN content USING (hash) WHERE take = ? ORDER BY "
      "number");
  files.with(number);
  while (files.next()) {
    TakeFile& file = take.files.emplace_back();
    file.role = static_cast<TakeFile::Role>(files.number());
    file.path = files.text();
    file.hash = files.text();
    file.text = files.text();
  }
  Statement events(database_, "SELECT tick, kind, text FROM event WHERE take = ? ORDER BY tick, rowid");
  events.with(number);
  while (events.next()) {
    TakeEvent& event = take.events.emplace_back();
    event.tick = events.number();
    event.kind = static_cast<TakeEvent::Kind>(events.number());
    event.text = events.text();
  }
  return take;
}

void TakeStore::read_ticks(const Take& head, const std::function<bool(const TakeTick&)>& tick) {
  const std::string damaged = "move the file away, or forget the take with inbetween takes delete";
  const std::unique_ptr<TakenMotion> motion = TakenMotion::read(head.trajectory);
  if (!motion) database_.fail(fmt::format("what take {} played is damaged", head.number), damaged);
  const TickShape shape{
      .axes = head.axes, .motion = &motion->motion(), .frame_rate = head.frame_rate, .rate_hz = head.rate_hz};
  Statement chunks(database_, "SELECT first_tick, bytes FROM chunk WHERE take = ? ORDER BY first_tick");
  chunks.with(head.number);
  bool goes_on = true;
  while (goes_on && chunks.next()) {
    const std::int64_t first = chunks.number();
    const std::string wrong = decode_ticks(chunks.text(), shape, [&](const TakeTick& one) {
      goes_on = tick(one);
      return goes_on;
    });
    if (!wrong.empty())
      database_.fail(fmt::format("take {} is damaged from tick {} on: {}", head.number, first, wrong),
                     damaged);
  }
}

Take TakeStore::read(std::int64_t number) {
  Take take = read_head(number);
  read_ticks(take, [&](const TakeTick& tick) {
    take.ticks_of_take.push_back(tick);
    return true;
  });
  return take;
}

// --- keeping and forgetting

void TakeStore::forget_unused_content() {
  database_.execute(
      "DELETE FROM content WHERE NOT EXISTS (SELECT 1 FROM file WHERE file.hash = content.hash) AND NOT "
      "EXISTS (SELECT 1 FROM take WHERE take.trajectory = content.hash)");
}

void TakeStore::forget(std::int64_t take) {
  refuse_unknown(take);
  remove(take);
}

void TakeStore::remove(std::int64_t take) {
  {
    Transaction transaction(database_);
    Statement(database_, "DELETE FROM take WHERE number = ?").with(take).run();
    forget_unused_content();
    transaction.commit();
  }
  give_room_back();
}

/// In portions: all at once the write-ahead log would grow by what is moved, which is as much as was
/// forgotten, and stay so large until the last program has closed the file.
void TakeStore::give_room_back() {
  std::int64_t free = database_.number_of("PRAGMA freelist_count");
  while (free > 0) {
    database_.execute("PRAGMA incremental_vacuum(1000)");
    const std::int64_t left = database_.number_of("PRAGMA freelist_count");
    if (left >= free) return;  // another program takes as many
    free = left;
  }
}

void TakeStore::mark(std::int64_t take, bool is_marked) {
  refuse_unknown(take);
  Statement(database_, "UPDATE take SET is_marked = ? WHERE number = ?").with(is_marked).with(take).run();
}

std::int64_t TakeStore::used_bytes() {
  return (database_.number_of("PRAGMA page_count") - database_.number_of("PRAGMA freelist_count")) *
         database_.number_of("PRAGMA page_size");
}

std::vector<std::int64_t> TakeStore::prune(std::int64_t max_bytes, std::optional<std::int64_t> but) {
  std::vector<std::int64_t> gone;
  for (;;) {
    const Pruned pruned = prune_some(max_bytes, all_chunks, but.value_or(0));
    if (pruned.gone) gone.push_back(*pruned.gone);
    if (pruned.is_done) return gone;
  }
}

/// One that has begun to go comes first.
std::optional<std::int64_t> TakeStore::next_to_go(std::int64_t but) {
  Statement first(
      database_,
      "SELECT number FROM take WHERE is_marked = 0 AND number <> ? ORDER BY is_going DESC, number");
  return first.with(but).next() ? std::optional(first.number()) : std::nullopt;
}

TakeStore::Pruned TakeStore::prune_some(std::int64_t max_bytes, std::int64_t chunks, std::int64_t but) {
  const bool is_begun = database_.number_of("SELECT count(*) FROM take WHERE is_going = 1") > 0;
  if (!is_begun && used_bytes() <= max_bytes) return {};
  const std::optional<std::int64_t> take = next_to_go(but);
  if (!take) return {};
  std::int64_t left = 0;
  {
    Transaction transaction(database_);
    Statement(database_, "UPDATE take SET is_going = 1 WHERE number = ?").with(*take).run();
    Statement(database_, "DELETE FROM chunk WHERE rowid IN (SELECT rowid FROM chunk WHERE take = ? LIMIT ?)")
        .with(*take)
        .with(chunks)
        .run();
    Statement rest(database_, "SELECT count(*) FROM chunk WHERE take = ?");
    if (rest.with(*take).next()) left = rest.number();
    transaction.commit();
  }
  if (left > 0) {
    give_room_back();
    return {.is_done = false};
  }
  remove(*take);
  return {.is_done = false, .gone = take};
}

// --- words

std::string hash_of_content(std::string_view bytes) {
  return fmt::format("{}-{:016x}", bytes.size(), sum_of(bytes));
}

std::optional<std::int64_t> size_in_bytes(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !(number > 0)) return std::nullopt;
  const std::string_view unit(end, text.data() + text.size());
  double factor = 1;
  if (unit == "k") {
    factor = 1e3;
  } else if (unit == "M") {
    factor = 1e6;
  } else if (unit == "G") {
    factor = 1e9;
  } else if (!unit.empty()) {
    return std::nullopt;
  }
  constexpr double most = 1e15;
  return number * factor <= most ? std::optional(std::llround(number * factor)) : std::nullopt;
}

std::string size_in_words(std::int64_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size < 999.5) return fmt::format("{} B", bytes);
  if (size < 999.5e3) return fmt::format("{:.3g} kB", size / 1e3);
  return size < 999.5e6 ? fmt::format("{:.3g} MB", size / 1e6) : fmt::format("{:.3g} GB", size / 1e9);
}

}  // namespace inbetween
