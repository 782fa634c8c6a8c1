// The takes of a project folder, in one SQLite file. docs/takes.md describes its tables.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/takes/take.hpp"
#include "host_tools/takes/take_database.hpp"

namespace inbetween {

/// Its name in a project folder, which is that of the move file.
inline constexpr const char* take_file_name = "inbetween-takes.db";

/// A chunk of the ticks of a take (tick_codec.hpp).
struct TakeChunk {
  std::int64_t first = 0;  ///< number of its first tick
  std::int64_t ticks = 0;
  std::string bytes;
};

/// One thread uses it; several programs may have the file open at once. What a call has done, the file keeps
/// through the end of the program, whatever ends it; what finish() has done, through a power cut as well (a
/// write-ahead log, synchronised then). Whatever happens the file can be opened again.
///
/// A disk that is full, lost or write-protected: the call throws, and the file has what it had before. A file
/// on a write-protected disk can be read. Where a program that was killed has left takes in its log, that is
/// done from a copy of both in the folder for temporary files, which needs the room there and goes with the
/// store.
class TakeStore {
 public:
  enum class Access : std::uint8_t {
    write,  ///< makes the file where there is none
    read,   ///< makes no file; takes can be marked and forgotten, too
  };

  /// Throws TakeStoreError where the file cannot be opened, is another program's or of a newer version.
  TakeStore(const std::string& file, Access access);

  [[nodiscard]] const std::string& file() const { return database_.file(); }

  // All throw TakeStoreError.

  /// Begins a take with all but its ticks, its ending and its events. Returns its number.
  std::int64_t begin(const Take& take);
  /// Its chunks follow each other. `lost_ticks` are those so far.
  void append(std::int64_t take, const TakeChunk& chunk, const std::vector<TakeEvent>& events,
              std::int64_t lost_ticks);
  /// What it ended like; its number of ticks is known already.
  void finish(std::int64_t take, const std::string& ending, bool is_whole, std::int64_t lost_ticks);

  /// In the order of their numbers. Reads no tick.
  [[nodiscard]] std::vector<TakeInfo> list();
  /// Without ticks. Throws where there is no such take, too.
  [[nodiscard]] Take read_head(std::int64_t number);
  /// Whole. Memory: 16 bytes a tick and axis, and 100 a tick.
  [[nodiscard]] Take read(std::int64_t number);
  /// Tick by tick, until `tick` returns false.
  void read_ticks(const Take& head, const std::function<bool(const TakeTick&)>& tick);

  void forget(std::int64_t take);
  void mark(std::int64_t take, bool is_marked);
  /// Forgets the oldest takes that are not marked, until what is kept takes no more than so many bytes, and
  /// gives the room back to the disk. Never `but`. Returns the numbers of those that went.
  std::vector<std::int64_t> prune(std::int64_t max_bytes, std::optional<std::int64_t> but = std::nullopt);
  /// The same in portions of so many chunks, for a thread that has other things to do: forgets that much of
  /// the oldest take. One that has begun to go is in no list any more, and goes on whatever max_bytes is.
  struct Pruned {
    bool is_done = true;                    ///< nothing is left to be forgotten
    std::optional<std::int64_t> gone = {};  ///< the take that is wholly gone by this
  };
  Pruned prune_some(std::int64_t max_bytes, std::int64_t chunks, std::int64_t but);
  /// That the takes need; the file may have more.
  [[nodiscard]] std::int64_t used_bytes();

 private:
  void open(Access access);
  [[nodiscard]] bool lacks_its_index();
  void open_write_protected();
  void make_tables();
  std::string keep_content(const std::string& bytes);
  void keep_parts(std::int64_t number, const Take& take);
  void forget_unused_content();
  [[nodiscard]] std::optional<std::int64_t> next_to_go(std::int64_t but);
  void remove(std::int64_t take);
  void give_room_back();
  void refuse_unknown(std::int64_t take);

  TakeDatabase database_;
};

/// A hash of bytes: their number and FNV-1a, "1234-0123456789abcdef".
std::string hash_of_content(std::string_view bytes);

/// 10k, 1.5M, 2G as bytes; nothing where that is no size.
std::optional<std::int64_t> size_in_bytes(std::string_view text);
/// "312 kB", "1.2 MB".
std::string size_in_words(std::int64_t bytes);

}  // namespace inbetween
