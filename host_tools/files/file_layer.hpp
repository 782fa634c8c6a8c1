// The operations on files by which something is kept through a power cut, so that a test can cut the power
// at each of them.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace inbetween {

/// Each returns an errno, 0 if it succeeded.
struct FileLayer {
  /// The bytes of a regular file; EFBIG for one above `most` bytes.
  std::function<int(const std::string& path, std::size_t most, std::string& bytes)> read;
  /// Creates the file, or empties it.
  std::function<int(const std::string& path, int& descriptor)> create;
  /// May write less than all, but at least one byte.
  std::function<int(int descriptor, std::string_view bytes, std::size_t& written)> write;
  std::function<int(int descriptor)> sync;
  std::function<int(int descriptor)> close;
  std::function<int(const std::string& from, const std::string& to)> rename;
  std::function<int(const std::string& folder)> sync_folder;
  /// One folder; EEXIST if there is something of that name.
  std::function<int(const std::string& folder)> make_folder;
};

/// Those of Linux.
FileLayer system_files();

/// An operation that failed, on which file, and why.
struct FileFailure {
  std::string_view what;  // "cannot be written"
  std::string path;
  int error = 0;  // errno; 0: all went well
  explicit operator bool() const { return error != 0; }
};

/// Replaces `path` by a file of `bytes` so that after a power cut at any moment there is the old file or the
/// new one, whole: writes PATH.part, syncs it, renames it, syncs the folder. On return without a failure the
/// new file is there for good. After a failure either may be.
FileFailure replace_durably(const FileLayer& files, const std::string& path, std::string_view bytes);

/// Makes `folder` and those above it that are missing, for good.
FileFailure make_folders(const FileLayer& files, const std::string& folder);

}  // namespace inbetween
