#include "host_tools/takes/take_store.hpp"

#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "host_tools/takes/byte_text.hpp"
#include "host_tools/takes/database_file.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/tick_codec.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// "ibtw"
constexpr std::int64_t application_id = 0x69627477;
constexpr std::int64_t newest_version = 1;
/// Somebody else writes for milliseconds, unless their disk is slow.
constexpr int patience_ms = 5000;
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

const char* remedy_of(int code) {
  switch (code) {
    case SQLITE_FULL:
      return "make room on the disk, or forget takes with inbetween takes delete or --keep SIZE";
    case SQLITE_READONLY:
      return "it is write-protected: copy it to a folder that you may write to";
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return "choose a folder that exists and that you may write to with --takes-in FILE, or --no-take";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program is writing takes there; do it again, or name another file";
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "it is damaged, or no file of takes: move it away, and sqlite3 FILE .recover may read the rest";
    default:
      return "look at the disk, or name another file with --takes-in FILE";
  }
}

}  // namespace

TakeStoreError::TakeStoreError(const std::string& file, std::string message)
    : std::runtime_error(file + ": error: " + message), message_(std::move(message)) {}

// --- the open file, a statement, and a transaction that is taken back unless it was committed

class TakeStore::Database {
 public:
  Database() = default;
  ~Database() { sqlite3_close(database_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// SQLite's code. A thread at a time uses it.
  int open(const std::string& address, int how) {
    const int code =
        sqlite3_open_v2(address.c_str(), &database_, how | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    if (code == SQLITE_OK) sqlite3_busy_timeout(database_, patience_ms);
    return code;
  }
  /// Until it is closed.
  void keep(std::unique_ptr<DatabaseCopy> copy) { copy_ = std::move(copy); }
  [[nodiscard]] sqlite3* get() const { return database_; }

 private:
  std::unique_ptr<DatabaseCopy> copy_;
  sqlite3* database_ = nullptr;
};

class TakeStore::Statement {
 public:
  Statement(TakeStore& store, const std::string& sql) : store_(store) {
    if (sqlite3_prepare_v2(store.database_->get(), sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK)
      store.fail();
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& with(std::int64_t value) { return checked(sqlite3_bind_int64(statement_, ++bound_, value)); }
  Statement& with(std::int32_t value) { return with(std::int64_t{value}); }
  Statement& with(bool value) { return with(std::int64_t{value ? 1 : 0}); }
  Statement& with(double value) { return checked(sqlite3_bind_double(statement_, ++bound_, value)); }
  Statement& with(const std::optional<std::size_t>& value) {
    if (value) return with(static_cast<std::int64_t>(*value));
    return checked(sqlite3_bind_null(statement_, ++bound_));
  }
  Statement& with(const std::string& text) {
    return checked(
        sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  }
  Statement& with_bytes(const std::string& bytes) {
    return checked(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
  }

  /// Whether there is another row.
  bool next() {
    read_ = 0;
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) store_.fail();
    return code == SQLITE_ROW;
  }
  void run() {
    while (next()) {
    }
  }

  // The columns of a row, one after the other.
  std::int64_t number() { return sqlite3_column_int64(statement_, read_++); }
  std::int32_t small() { return static_cast<std::int32_t>(number()); }
  bool truth() { return number() != 0; }
  double real() { return sqlite3_column_double(statement_, read_++); }
  std::string text() {
    const int column = read_++;
    const void* bytes = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
  }
  std::optional<std::size_t> maybe() {
    const int column = read_++;
    if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
    return static_cast<std::size_t>(sqlite3_column_int64(statement_, column));
  }

 private:
  Statement& checked(int code) {
    if (code != SQLITE_OK) store_.fail();
    return *this;
  }

  TakeStore& store_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  int read_ = 0;
};

class TakeStore::Transaction {
 public:
  explicit Transaction(TakeStore& store) : store_(store) { store.execute("BEGIN IMMEDIATE"); }
  ~Transaction() {
    // SQLite has taken it back by itself after some errors.
    if (!is_done_) sqlite3_exec(store_.database_->get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit() {
    store_.execute("COMMIT");
    is_done_ = true;
  }

 private:
  TakeStore& store_;
  bool is_done_ = false;
};

// --- the file

TakeStore::TakeStore(const std::string& file, Access access) : file_(file) {
  open(access);
}

TakeStore::~TakeStore() = default;

void TakeStore::open(Access access) {
  std::error_code unknown;
  if (access == Access::read && !std::filesystem::exists(file_, unknown)) {
    fail("there are no takes", "inbetween run keeps them in the folder of the move; name another with --in");
  }
  const int how = access == Access::read ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  open_database(address_of_database(file_), how);
  if (access == Access::read && lacks_its_index()) open_write_protected();
  execute("PRAGMA foreign_keys = ON");
  const std::int64_t id = number_of("PRAGMA application_id");
  const std::int64_t version = number_of("PRAGMA user_version");
  const bool is_new = number_of("SELECT count(*) FROM sqlite_schema") == 0 && id == 0;
  if (!is_new && id != application_id) fail("this is no file of takes", "name another file");
  if (version > newest_version)
    fail(fmt::format("it is of version {}, and this program knows {}", version, newest_version),
         "use a newer inbetween, or another file");
  if (access == Access::read && is_new) fail("there are no takes in it", "inbetween run keeps them");
  if (access == Access::read) return;
  if (sqlite3_db_readonly(database_->get(), "main") == 1)
    fail("it is write-protected", "choose a file that you may write to with --takes-in FILE, or --no-take");
  if (is_new) make_tables();
  execute("PRAGMA journal_mode = WAL");
  execute("PRAGMA synchronous = NORMAL");
  // Where somebody reads for long the log grows beyond; then it is cut off again.
  execute("PRAGMA journal_size_limit = 4000000");
}

void TakeStore::open_database(const std::string& address, int how) {
  database_ = std::make_unique<Database>();
  if (database_->open(address, how) != SQLITE_OK) fail();
}

/// Whoever reads a file with a write-ahead log needs its index, FILE-shm, and makes one where there is none:
/// not where the folder is write-protected.
bool TakeStore::lacks_its_index() {
  if (!refusal_beside(file_)) return false;
  const int code =
      sqlite3_exec(database_->get(), "SELECT 1 FROM sqlite_schema", nullptr, nullptr, nullptr) & 0xFF;
  return code == SQLITE_CANTOPEN || code == SQLITE_READONLY;
}

/// Nobody has the file open, or it would have its index. So nobody writes, and without a log the file can be
/// read as it is ("Write-Ahead Logging: Read-Only Databases" of SQLite's documents). Immutable, SQLite would
/// not see what is in a log alone: then it reads a copy, which can have an index. A change in the copy would
/// be lost.
void TakeStore::open_write_protected() {
  if (!has_database_log(file_)) {
    open_database(address_of_database(file_) + "?immutable=1", SQLITE_OPEN_READONLY);
    return;
  }
  std::unique_ptr<DatabaseCopy> copy;
  try {
    copy = std::make_unique<DatabaseCopy>(file_);
  } catch (const std::system_error& error) {
    fail(fmt::format("it is write-protected, and it takes a copy to read what is in its log alone: {}",
                     error.code().message()),
         "make room for temporary files, or name a folder for them in TMPDIR");
  }
  open_database(address_of_database(copy->path()), SQLITE_OPEN_READWRITE);
  database_->keep(std::move(copy));
  execute("PRAGMA query_only = ON");
}

/// Two programs may come here at once.
void TakeStore::make_tables() {
  execute("PRAGMA auto_vacuum = INCREMENTAL");
  execute("PRAGMA journal_mode = WAL");
  Transaction transaction(*this);
  if (number_of("PRAGMA application_id") == 0) {
    execute(tables);
    execute(fmt::format("PRAGMA application_id = {}", application_id).c_str());
    execute(fmt::format("PRAGMA user_version = {}", newest_version).c_str());
  }
  transaction.commit();
}

void TakeStore::execute(const char* sql) {
  if (sqlite3_exec(database_->get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::int64_t TakeStore::number_of(const char* sql) {
  Statement statement(*this, sql);
  return statement.next() ? statement.number() : 0;
}

void TakeStore::fail() {
  const int code = sqlite3_extended_errcode(database_->get());
  std::string what = sqlite3_errmsg(database_->get());
  // "disk I/O error" is said better by what the kernel has said.
  int system = sqlite3_system_errno(database_->get());
  // SQLite tries to read what it cannot make, and the last error is that of reading.
  if (const std::error_code refusal = refusal_beside(file_); (code & 0xFF) == SQLITE_CANTOPEN && refusal)
    system = refusal.value();
  const bool is_of_disk = (code & 0xFF) == SQLITE_IOERR || (code & 0xFF) == SQLITE_CANTOPEN;
  if (is_of_disk && system != 0) what += fmt::format(": {}", std::strerror(system));
  const bool is_full = is_of_disk && (system == ENOSPC || system == EFBIG || system == EDQUOT);
  fail(what, remedy_of(is_full ? SQLITE_FULL : code & 0xFF));
}

void TakeStore::fail(const std::string& what, const std::string& remedy) const {
  throw TakeStoreError(file_, what + "; " + remedy);
}

// --- writing a take

/// What several takes have the same is kept once.
std::string TakeStore::keep_content(const std::string& bytes) {
  std::string hash = hash_of_content(bytes);
  Statement(*this, "INSERT OR IGNORE INTO content VALUES (?, ?)").with(hash).with_bytes(bytes).run();
  return hash;
}

/// Its axes and files.
void TakeStore::keep_parts(std::int64_t number, const Take& take) {
  std::int32_t row = 0;
  for (const TakeAxis& axis : take.axes) {
    Statement(*this, "INSERT INTO axis VALUES (?, ?, ?, ?, ?, ?)")
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
    Statement(*this, "INSERT INTO file VALUES (?, ?, ?, ?, ?)")
        .with(number)
        .with(row++)
        .with(static_cast<std::int32_t>(file.role))
        .with(file.path)
        .with(keep_content(file.text))
        .run();
  }
}

std::int64_t TakeStore::begin(const Take& take) {
  Transaction transaction(*this);
  std::int64_t bytes = static_cast<std::int64_t>(take.trajectory.size());
  for (const TakeFile& file : take.files) bytes += static_cast<std::int64_t>(file.text.size());
  Statement(*this,
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
  const std::int64_t number = sqlite3_last_insert_rowid(database_->get());
  keep_parts(number, take);
  transaction.commit();
  return number;
}

void TakeStore::append(std::int64_t take, const TakeChunk& chunk, const std::vector<TakeEvent>& events,
                       std::int64_t lost_ticks) {
  Transaction transaction(*this);
  auto bytes = static_cast<std::int64_t>(chunk.bytes.size());
  if (chunk.ticks > 0) {
    Statement(*this, "INSERT INTO chunk VALUES (?, ?, ?, ?)")
        .with(take)
        .with(chunk.first)
        .with(chunk.ticks)
        .with_bytes(chunk.bytes)
        .run();
  }
  for (const TakeEvent& event : events) {
    Statement(*this, "INSERT INTO event VALUES (?, ?, ?, ?)")
        .with(take)
        .with(event.tick)
        .with(static_cast<std::int32_t>(event.kind))
        .with(event.text)
        .run();
    bytes += static_cast<std::int64_t>(event.text.size());
  }
  Statement(*this, "UPDATE take SET ticks = ticks + ?, lost_ticks = ?, bytes = bytes + ? WHERE number = ?")
      .with(chunk.ticks)
      .with(lost_ticks)
      .with(bytes)
      .with(take)
      .run();
  transaction.commit();
}

void TakeStore::finish(std::int64_t take, const std::string& ending, bool is_whole, std::int64_t lost_ticks) {
  execute("PRAGMA synchronous = FULL");
  Transaction transaction(*this);
  Statement(*this, "UPDATE take SET ending = ?, is_whole = ?, lost_ticks = ? WHERE number = ?")
      .with(ending)
      .with(is_whole)
      .with(lost_ticks)
      .with(take)
      .run();
  transaction.commit();
  execute("PRAGMA synchronous = NORMAL");
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
  Statement rows(*this, fmt::format("SELECT {} FROM take WHERE is_going = 0 ORDER BY number", info_columns));
  while (rows.next()) read_info(rows, all.emplace_back());
  return all;
}

void TakeStore::refuse_unknown(std::int64_t take) {
  Statement there(*this, "SELECT 1 FROM take WHERE number = ? AND is_going = 0");
  if (!there.with(take).next())
    fail(fmt::format("there is no take {}", take), "inbetween takes list shows all");
}

Take TakeStore::read_head(std::int64_t number) {
  refuse_unknown(number);
  Take take;
  Statement row(*this, fmt::format("SELECT {}, (SELECT bytes FROM content WHERE hash = trajectory) FROM take "
                                   "WHERE number = ?",
                                   info_columns));
  if (row.with(number).next()) {
    read_info(row, take);
    take.trajectory = row.text();
  }
  Statement axes(*this, "SELECT name, unit, resolution, move_axis FROM axis WHERE take = ? ORDER BY number");
  axes.with(number);
  while (axes.next()) {
    TakeAxis& axis = take.axes.emplace_back();
    axis.name = axes.text();
    axis.unit = axes.text();
    axis.resolution = axes.real();
    axis.move_axis = axes.maybe();
  }
  Statement files(
      *this,
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
  Statement events(*this, "SELECT tick, kind, text FROM event WHERE take = ? ORDER BY tick, rowid");
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
  if (!motion) fail(fmt::format("what take {} played is damaged", head.number), damaged);
  const TickShape shape{
      .axes = head.axes, .motion = &motion->motion(), .frame_rate = head.frame_rate, .rate_hz = head.rate_hz};
  Statement chunks(*this, "SELECT first_tick, bytes FROM chunk WHERE take = ? ORDER BY first_tick");
  chunks.with(head.number);
  bool goes_on = true;
  while (goes_on && chunks.next()) {
    const std::int64_t first = chunks.number();
    const std::string wrong = decode_ticks(chunks.text(), shape, [&](const TakeTick& one) {
      goes_on = tick(one);
      return goes_on;
    });
    if (!wrong.empty())
      fail(fmt::format("take {} is damaged from tick {} on: {}", head.number, first, wrong), damaged);
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
  execute(
      "DELETE FROM content WHERE NOT EXISTS (SELECT 1 FROM file WHERE file.hash = content.hash) AND NOT "
      "EXISTS (SELECT 1 FROM take WHERE take.trajectory = content.hash)");
}

void TakeStore::forget(std::int64_t take) {
  refuse_unknown(take);
  remove(take);
}

void TakeStore::remove(std::int64_t take) {
  {
    Transaction transaction(*this);
    Statement(*this, "DELETE FROM take WHERE number = ?").with(take).run();
    forget_unused_content();
    transaction.commit();
  }
  give_room_back();
}

/// In portions: all at once the write-ahead log would grow by what is moved, which is as much as was
/// forgotten, and stay so large until the last program has closed the file.
void TakeStore::give_room_back() {
  std::int64_t free = number_of("PRAGMA freelist_count");
  while (free > 0) {
    execute("PRAGMA incremental_vacuum(1000)");
    const std::int64_t left = number_of("PRAGMA freelist_count");
    if (left >= free) return;  // another program takes as many
    free = left;
  }
}

void TakeStore::mark(std::int64_t take, bool is_marked) {
  refuse_unknown(take);
  Statement(*this, "UPDATE take SET is_marked = ? WHERE number = ?").with(is_marked).with(take).run();
}

std::int64_t TakeStore::used_bytes() {
  return (number_of("PRAGMA page_count") - number_of("PRAGMA freelist_count")) *
         number_of("PRAGMA page_size");
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
      *this, "SELECT number FROM take WHERE is_marked = 0 AND number <> ? ORDER BY is_going DESC, number");
  return first.with(but).next() ? std::optional(first.number()) : std::nullopt;
}

TakeStore::Pruned TakeStore::prune_some(std::int64_t max_bytes, std::int64_t chunks, std::int64_t but) {
  const bool is_begun = number_of("SELECT count(*) FROM take WHERE is_going = 1") > 0;
  if (!is_begun && used_bytes() <= max_bytes) return {};
  const std::optional<std::int64_t> take = next_to_go(but);
  if (!take) return {};
  std::int64_t left = 0;
  {
    Transaction transaction(*this);
    Statement(*this, "UPDATE take SET is_going = 1 WHERE number = ?").with(*take).run();
    Statement(*this, "DELETE FROM chunk WHERE rowid IN (SELECT rowid FROM chunk WHERE take = ? LIMIT ?)")
        .with(*take)
        .with(chunks)
        .run();
    Statement rest(*this, "SELECT count(*) FROM chunk WHERE take = ?");
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
