// MappedFile: a file's bytes, mapped read-only. Pages that were read can be given back, so that a file of any
// size is walked through in bounded memory. Move-only; one thread. Fails with kIo when the file cannot be
// opened or mapped. The file must not shrink while it is mapped.
#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

class MappedFile {
 public:
  static Result<MappedFile> Open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();

  LogBytes bytes() const { return {data_, size_}; }
  // Drops the resident pages that lie wholly before `offset`; they are read again if touched again.
  void ReleaseBefore(std::size_t offset) const;

 private:
  MappedFile(const std::uint8_t* bytes, std::size_t size) : data_(bytes), size_(size) {}
  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace skyquilt::flight
