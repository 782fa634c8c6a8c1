// The file operations that keep data through a power cut. A test replaces them and cuts the power at each
// one.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace inbetween {

/// Each operation returns an errno, or 0 if it succeeded.
struct FileLayer {
  /// Reads a regular file. EFBIG if it has more than `max_bytes` bytes.
  std::function<int(const std::string& path, std::size_t max_bytes, std::string& bytes)> read;
  /// Creates the file. EEXIST if the name is taken.
  std::function<int(const std::string& path, int& descriptor)> create;
  /// EACCES if the file at `path` may not be written, also where a user who may do everything asks. 0 where
  /// no file can be seen.
  std::function<int(const std::string& path)> may_write;
  /// ETXTBSY if somebody has the file open to write into it, as far as the kernel tells.
  std::function<int(const std::string& path)> being_written;
  /// Gives an open file the permissions of the file at `path`, and its owner and group as far as the kernel
  /// lets this user. Does nothing where no file is there.
  std::function<int(const std::string& path, int descriptor)> inherit;
  /// Writes at least one byte, maybe fewer than all.
  std::function<int(int descriptor, std::string_view bytes, std::size_t& written)> write;
  std::function<int(int descriptor)> sync;
  std::function<int(int descriptor)> close;
  std::function<int(const std::string& from, const std::string& to)> rename;
  /// The same to a name that nothing has. EEXIST if it is taken, EINVAL where the file system cannot tell.
  std::function<int(const std::string& from, const std::string& to)> rename_new;
  /// Gives each of two files the name of the other, in one moment. EINVAL where the file system cannot (NFS,
  /// FAT).
  std::function<int(const std::string& one, const std::string& other)> swap;
  std::function<int(const std::string& path)> remove;
  std::function<int(const std::string& folder)> sync_folder;
  /// Makes one folder. EEXIST if the name is taken.
  std::function<int(const std::string& folder)> make_folder;
};

/// The operations of Linux.
FileLayer system_files();

/// Gives an open file the permissions, and as far as it may, the owner and the group that stat() has told.
int inherit_from(const struct stat& status, int descriptor);
/// FileLayer::may_write of a file beneath the open folder `folder`, or AT_FDCWD.
int may_write_at(int folder, const char* path);
/// FileLayer::being_written of an open file.
int being_written(int descriptor);
/// What a call of Linux returned, 0 or -1 and errno, as such an errno.
int errno_of(int result);
/// FileLayer::read from where an open file stands to its end; `bytes` is empty before.
int read_open_file(int descriptor, std::size_t max_bytes, std::string& bytes);

/// A failed operation, its file and its reason.
struct FileFailure {
  std::string_view what;  // "cannot be written"
  std::string path;
  int error = 0;  // errno; 0: all went well
  explicit operator bool() const { return error != 0; }
};

/// The file that is written first, and then renamed to `path`. No other program gives its files such a name.
std::string part_of(const std::string& path);

/// Replaces `path` by a file of `bytes`. After a power cut at any moment the old file or the new one is
/// there, whole: this writes part_of(path), in the place of what a power cut has left there, which inherits
/// from the old file, syncs it, renames it, and syncs the folder. If it returns no failure, the new file
/// survives every power cut. After a failure either file may be there. A file that may not be written is not
/// replaced.
FileFailure replace_durably(const FileLayer& files, const std::string& path, std::string_view bytes);

/// The same of a file that has `expected` (nothing: that is not there). What somebody else writes stays, also
/// in the very moment: the names are swapped, what comes out is held to `expected`, and is put back where it
/// differs (ESTALE) or is still being written (ETXTBSY). Where the file system cannot swap (NFS, FAT), the
/// file is read directly before. What a second change in the same moment leaves over is kept as
/// part_of(path).
FileFailure replace_expected(const FileLayer& files, const std::string& path,
                             const std::optional<std::string>& expected, std::string_view bytes);

/// Makes `folder` and the missing folders above it, so that they survive a power cut.
FileFailure make_folders(const FileLayer& files, const std::string& folder);

}  // namespace inbetween
