// How a browser is told the address of a page, and nobody else: the key in it can edit the move.
#pragma once

#include <filesystem>
#include <string>

namespace inbetween {

/// A file that leads a browser on to `address`. What a program is started with can be read by every user of
/// the machine (ps); this file can be read by its owner only (mode 0600), in a folder of its own for
/// temporary files that nobody else can look into (0700). Both go with this object. Throws
/// std::runtime_error, one line, where they cannot be written.
class LaunchPage {
 public:
  explicit LaunchPage(const std::string& address);
  ~LaunchPage();
  LaunchPage(const LaunchPage&) = delete;
  LaunchPage& operator=(const LaunchPage&) = delete;

  [[nodiscard]] std::string path() const { return (folder_ / "inbetween.html").string(); }

 private:
  std::filesystem::path folder_;
};

}  // namespace inbetween
