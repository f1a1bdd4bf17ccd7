// BlockSpool: blocks that are kept in a file until it is known where they belong. The file has no name any
// more while it is used, so that it goes however the program ends. One thread. Errors: kIo, kOutOfSpace.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

class BlockSpool {
 public:
  static Result<std::unique_ptr<BlockSpool>> Create(const std::filesystem::path& path);
  ~BlockSpool();
  BlockSpool(const BlockSpool&) = delete;
  BlockSpool& operator=(const BlockSpool&) = delete;

  std::uint64_t length() const { return length_; }
  // Behind what is there: at length() as it was.
  Result<void> Append(std::string_view block);
  // After the last one, before the first is read.
  Result<void> Flush();
  Result<std::string> Read(std::uint64_t offset, std::uint64_t bytes);

 private:
  BlockSpool(std::filesystem::path path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  const std::filesystem::path path_;
  std::FILE* file_;
  std::uint64_t length_ = 0;
};

}  // namespace skyquilt::storage
