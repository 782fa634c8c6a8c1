// The files of a SQLite database with a write-ahead log, where they cannot be written.
#pragma once

#include <string>
#include <system_error>

namespace inbetween {

/// The address (URI) of a file, whatever its name. SQLite takes options behind it.
std::string address_of_database(const std::string& file);

/// What keeps this process from making a file beside the database, which is where SQLite has its log: beside
/// the file that links lead to. On a read-only disk that is nobody's to allow.
std::error_code refusal_beside(const std::string& file);

/// Whether a program that was ended has left something in the log that is not in the database.
bool has_database_log(const std::string& file);

/// A database with its log, in a folder of its own among the temporary files, which goes with it.
class DatabaseCopy {
 public:
  /// Throws std::system_error where no copy can be made.
  explicit DatabaseCopy(const std::string& file);
  ~DatabaseCopy();
  DatabaseCopy(const DatabaseCopy&) = delete;
  DatabaseCopy& operator=(const DatabaseCopy&) = delete;

  [[nodiscard]] std::string path() const { return folder_ + "/copy.db"; }

 private:
  std::string folder_;
};

}  // namespace inbetween
