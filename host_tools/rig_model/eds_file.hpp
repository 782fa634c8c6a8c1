// The objects of a CANopen device as its electronic data sheet tells them: an EDS file, or a DCF file, which
// has the values of one device besides (CiA 306).
//
// Read is what an object is, how long, who may read or write it, and what it has at first. Lists and counts
// of objects are passed over: makers get them wrong, and the sections say the same. So are names, which may
// be in any alphabet. CiA 306 lets a file leave a value out: then it is unknown until the drive is connected,
// and never 0. So it is where makers have written something else than a value; that is a warning with its
// line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

inline constexpr std::size_t max_eds_objects = 20'000;

struct EdsObject {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t size =
      0;  // of a number, 1 to 4 bytes; 0: it is none or of unknown type; `bytes` is what it has
  bool can_be_read = true;
  bool can_be_written = true;
  bool can_be_mapped = true;             // into a PDO; also where the file does not say
  std::optional<std::uint32_t> value{};  // ParameterValue of a DCF, or else DefaultValue; empty: unknown
  std::vector<std::uint8_t> bytes{};
  std::optional<std::uint32_t> low{}, high{};  // of a number without sign
  std::uint32_t line = 0;                      // of its section
};

struct EdsFile {
  std::string path;
  std::vector<EdsObject> objects;     // by index and sub-index
  std::vector<std::string> warnings;  // "FILE:LINE: warning: ...", in the order of their lines

  [[nodiscard]] const EdsObject* find(std::uint16_t index, std::uint8_t sub) const;
};

/// Throws InputError where the file cannot be read or has no object. `node` stands for $NODEID.
EdsFile read_eds_file(const std::filesystem::path& path, int node);
/// The same from text; `file_name` stands in places and in EdsFile::path.
EdsFile parse_eds(std::string_view text, const std::string& file_name, int node);

}  // namespace inbetween
