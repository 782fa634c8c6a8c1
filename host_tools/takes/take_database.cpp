#include "host_tools/takes/take_database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace inbetween {
namespace {

/// Somebody else writes for milliseconds, unless their disk is slow.
constexpr int patience_ms = 5000;

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

// --- the open file

void TakeDatabase::close() {
  sqlite3_close(database_);
  database_ = nullptr;
  copy_.reset();
}

void TakeDatabase::open(const std::string& address, int how) {
  close();
  const int code =
      sqlite3_open_v2(address.c_str(), &database_, how | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  if (code != SQLITE_OK) fail();
  sqlite3_busy_timeout(database_, patience_ms);
}

void TakeDatabase::open_copy(std::unique_ptr<DatabaseCopy> copy) {
  open(address_of_database(copy->path()), SQLITE_OPEN_READWRITE);
  copy_ = std::move(copy);
}

int TakeDatabase::attempt(const char* sql) {
  return sqlite3_exec(database_, sql, nullptr, nullptr, nullptr);
}

void TakeDatabase::execute(const char* sql) {
  if (attempt(sql) != SQLITE_OK) fail();
}

std::int64_t TakeDatabase::number_of(const char* sql) {
  Statement statement(*this, sql);
  return statement.next() ? statement.number() : 0;
}

std::int64_t TakeDatabase::last_row() const {
  return sqlite3_last_insert_rowid(database_);
}

bool TakeDatabase::is_write_protected() const {
  return sqlite3_db_readonly(database_, "main") == 1;
}

void TakeDatabase::fail() {
  const int code = sqlite3_extended_errcode(database_);
  std::string what = sqlite3_errmsg(database_);
  // "disk I/O error" is said better by what the kernel has said.
  int system = sqlite3_system_errno(database_);
  // SQLite tries to read what it cannot make, and the last error is that of reading.
  if (const std::error_code refusal = refusal_beside(file_); (code & 0xFF) == SQLITE_CANTOPEN && refusal)
    system = refusal.value();
  const bool is_of_disk = (code & 0xFF) == SQLITE_IOERR || (code & 0xFF) == SQLITE_CANTOPEN;
  if (is_of_disk && system != 0) what += fmt::format(": {}", std::strerror(system));
  const bool is_full = is_of_disk && (system == ENOSPC || system == EFBIG || system == EDQUOT);
  fail(what, remedy_of(is_full ? SQLITE_FULL : code & 0xFF));
}

void TakeDatabase::fail(const std::string& what, const std::string& remedy) const {
  throw TakeStoreError(file_, what + "; " + remedy);
}

// --- a statement

Statement::Statement(TakeDatabase& database, const std::string& sql) : database_(database) {
  if (sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) database.fail();
}

Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Statement& Statement::checked(int code) {
  if (code != SQLITE_OK) database_.fail();
  return *this;
}

Statement& Statement::with(std::int64_t value) {
  return checked(sqlite3_bind_int64(statement_, ++bound_, value));
}

Statement& Statement::with(double value) {
  return checked(sqlite3_bind_double(statement_, ++bound_, value));
}

Statement& Statement::with(const std::optional<std::size_t>& value) {
  if (value) return with(static_cast<std::int64_t>(*value));
  return checked(sqlite3_bind_null(statement_, ++bound_));
}

Statement& Statement::with(const std::string& text) {
  return checked(
      sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

Statement& Statement::with_bytes(const std::string& bytes) {
  return checked(sqlite3_bind_blob64(statement_, ++bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
}

bool Statement::next() {
  read_ = 0;
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail();
  return code == SQLITE_ROW;
}

void Statement::run() {
  while (next()) {
  }
}

std::int64_t Statement::number() {
  return sqlite3_column_int64(statement_, read_++);
}

double Statement::real() {
  return sqlite3_column_double(statement_, read_++);
}

std::string Statement::text() {
  const int column = read_++;
  const void* bytes = sqlite3_column_blob(statement_, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), size);
}

std::optional<std::size_t> Statement::maybe() {
  const int column = read_++;
  if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
  return static_cast<std::size_t>(sqlite3_column_int64(statement_, column));
}

// --- a transaction

Transaction::Transaction(TakeDatabase& database) : database_(database) {
  database.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // SQLite has taken it back by itself after some errors.
  if (!is_done_) database_.attempt("ROLLBACK");
}

void Transaction::commit() {
  database_.execute("COMMIT");
  is_done_ = true;
}

}  // namespace inbetween
