// The open file of takes: statements, transactions, and what went wrong in words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "host_tools/takes/database_file.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace inbetween {

/// Thrown where takes cannot be read or written. what() is "FILE: error: what; remedy".
class TakeStoreError : public std::runtime_error {
 public:
  TakeStoreError(const std::string& file, std::string message);
  /// The same without the file.
  [[nodiscard]] const std::string& message() const { return message_; }

 private:
  std::string message_;
};

/// A thread at a time uses it. All but the first two throw TakeStoreError.
class TakeDatabase {
 public:
  explicit TakeDatabase(std::string file) : file_(std::move(file)) {}
  ~TakeDatabase() { close(); }
  TakeDatabase(const TakeDatabase&) = delete;
  TakeDatabase& operator=(const TakeDatabase&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }

  /// In place of what was open. `how`: SQLITE_OPEN_...
  void open(const std::string& address, int how);
  /// The same with a copy, which lives as long as this.
  void open_copy(std::unique_ptr<DatabaseCopy> copy);
  /// SQLite's code of a statement that is tried, without an error.
  int attempt(const char* sql);
  void execute(const char* sql);
  /// Of the first column of the first row; 0 where there is none.
  [[nodiscard]] std::int64_t number_of(const char* sql);
  [[nodiscard]] std::int64_t last_row() const;
  [[nodiscard]] bool is_write_protected() const;
  [[nodiscard]] sqlite3* get() const { return database_; }

  /// What SQLite or the kernel has said last.
  [[noreturn]] void fail();
  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const;

 private:
  void close();

  std::string file_;
  std::unique_ptr<DatabaseCopy> copy_;
  sqlite3* database_ = nullptr;
};

/// All throw TakeStoreError.
class Statement {
 public:
  Statement(TakeDatabase& database, const std::string& sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& with(std::int64_t value);
  Statement& with(std::int32_t value) { return with(std::int64_t{value}); }
  Statement& with(bool value) { return with(std::int64_t{value ? 1 : 0}); }
  Statement& with(double value);
  Statement& with(const std::optional<std::size_t>& value);
  Statement& with(const std::string& text);
  Statement& with_bytes(const std::string& bytes);

  /// Whether there is another row.
  bool next();
  void run();

  // The columns of a row, one after the other.
  std::int64_t number();
  std::int32_t small() { return static_cast<std::int32_t>(number()); }
  bool truth() { return number() != 0; }
  double real();
  std::string text();
  std::optional<std::size_t> maybe();

 private:
  Statement& checked(int code);

  TakeDatabase& database_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  int read_ = 0;
};

/// It is taken back unless it was committed.
class Transaction {
 public:
  explicit Transaction(TakeDatabase& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit();

 private:
  TakeDatabase& database_;
  bool is_done_ = false;
};

}  // namespace inbetween
