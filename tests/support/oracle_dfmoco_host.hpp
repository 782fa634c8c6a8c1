// The host's side of DFMoco, written from its description alone: it shares nothing with the device.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace inbetween::oracle {

/// A line with its end.
std::vector<std::uint8_t> dfmoco_bytes(const std::string& line);

/// Reads what a device says. A host matches lines by their letters and motor, never by their order.
class DfmocoHost {
 public:
  /// Throws std::runtime_error where a line does not end in CR LF.
  void hear(const std::string& text);
  /// The lines since the last call.
  std::vector<std::string> take_lines();
  /// From all `mp` lines: the last position of a motor. Throws std::out_of_range where none was told.
  [[nodiscard]] long position(std::size_t motor) const;

 private:
  std::vector<std::string> lines_;
  std::vector<std::vector<long>> positions_;
};

}  // namespace inbetween::oracle
