// The address of a move's page, the same at every launch: a page that is open finds a program that was
// started again.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace inbetween {

/// Another program edits the move; what() is one line.
class EditedElsewhere : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// 128 bits from the kernel, in hexadecimal. Throws std::runtime_error where it has none.
std::string random_key();

/// The key and the ports of one move, in a file that only its owner may read (mode 0600). A file that
/// somebody else could have read, or that says something else, is written anew with another key. No two
/// programs have it at a time.
class KeptAddress {
 public:
  /// `move` is the path of the file itself, without symbolic links. Throws EditedElsewhere, and
  /// std::runtime_error, one line, where nothing can be kept in `folder`.
  KeptAddress(const std::filesystem::path& folder, std::string move);
  ~KeptAddress();
  KeptAddress(const KeptAddress&) = delete;
  KeptAddress& operator=(const KeptAddress&) = delete;

  [[nodiscard]] const std::string& key() const { return key_; }
  /// In the order in which they are tried: a page of the first launch is found first.
  [[nodiscard]] const std::vector<int>& ports() const { return ports_; }
  void add_port(int port);

 private:
  void load();
  void store() const;

  std::string path_, move_, key_;
  std::vector<int> ports_;
  int descriptor_ = -1;
};

/// Tells a file from every other one of this machine: a hash of its path.
std::string file_id(const std::string& path);

}  // namespace inbetween
