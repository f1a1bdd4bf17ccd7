// StreamFile: a large file written from front to back under `<path>.tmp` and published by rename after fsync;
// gone if it is not published. Failures are kept and returned by Publish, so that single writes need no
// check. One thread. Errors: kOutOfSpace, kIo.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

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
