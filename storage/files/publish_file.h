// Publishing a finished file: bytes on the disk first, then the name, then the folder. Any thread.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"

namespace skyquilt::storage {

// What the system said of a file, as an Error: kOutOfSpace where the disk is full, else kIo.
Error FileError(const std::string& what, const std::filesystem::path& path, int number);

// Whether errno says that there is no room: on the disk, by a quota, or in what a file of this process may
// take.
bool IsNoRoom(int number);

// Gone at the end of the scope, where it is still there.
class TemporaryFile {
 public:
  TemporaryFile(std::filesystem::path path, const char* ending) : path_(std::move(path)) { path_ += ending; }
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const char* c_str() const { return path_.c_str(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// What was made, renamed or removed in a folder stays so through a power cut, where the disk can do that.
// Errors: kIo, kOutOfSpace.
Result<void> SyncFolder(const std::filesystem::path& folder);

// fsync(temporary), rename to `path`, fsync of the folder. Errors: kIo, kOutOfSpace.
Result<void> PublishFile(const std::filesystem::path& temporary, const std::filesystem::path& path);
// Writes `bytes` under a temporary name and publishes it.
Result<void> WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);
// Of a file written so. Errors: kNotFound, kIo.
Result<std::string> ReadWholeFile(const std::filesystem::path& path);
// Fewer bytes only at its end; never through a link. Errors: kNotFound, kIo.
Result<std::string> ReadRangeOfFile(const std::filesystem::path& path, std::int64_t offset,
                                    std::int64_t length);

// StreamFile: a large file written from front to back under `<path>.tmp` and published by rename after fsync;
// gone if it is not published. Failures are kept and returned by Publish, so that single writes need no
// check. One thread. Errors: kOutOfSpace, kIo.
class StreamFile {
 public:
  static Result<std::unique_ptr<StreamFile>> Create(const std::filesystem::path& path);
  ~StreamFile();
  StreamFile(const StreamFile&) = delete;
  StreamFile& operator=(const StreamFile&) = delete;

  void Write(std::string_view bytes);
  // Overwrites what was written before; the next Write goes on at the end.
  void WriteAt(std::uint64_t offset, std::string_view bytes);
  std::uint64_t position() const { return position_; }
  Result<void> Publish();

 private:
  StreamFile(std::filesystem::path path, std::filesystem::path temporary, std::FILE* file)
      : path_(std::move(path)), temporary_(std::move(temporary)), file_(file) {}
  void Keep(bool went_well);

  const std::filesystem::path path_;
  const std::filesystem::path temporary_;
  std::FILE* file_;
  std::uint64_t position_ = 0;
  int failure_ = 0;  // errno of the first failure
};

}  // namespace skyquilt::storage
