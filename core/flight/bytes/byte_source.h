// The bytes of a file. ByteSource: bytes that can be read at any offset, from memory or from a file, so that
// a header reader touches only what it asks for; reads are all or nothing and never past the end. MappedFile:
// all of them, mapped. One thread per object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  // Fills `into` from `offset` on; false (and `into` unspecified) when the range leaves the source or the
  // disk fails.
  virtual bool Read(std::uint64_t offset, std::span<std::uint8_t> into) = 0;

  // At most `count` bytes from `offset` on; shorter only where the source ends.
  std::vector<std::uint8_t> ReadUpTo(std::uint64_t offset, std::size_t count);
};

// Bytes owned elsewhere; they must outlive this.
class MemoryBytes final : public ByteSource {
 public:
  explicit MemoryBytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  bool Read(std::uint64_t offset, std::span<std::uint8_t> into) override;

 private:
  std::span<const std::uint8_t> bytes_;
};

// Errors: kIo, kNotFound; kUnsupportedFormat for what is not a regular file.
Result<std::unique_ptr<ByteSource>> OpenFileBytes(const std::filesystem::path& path);

// A file's bytes, mapped read-only. Pages that were read can be given back, so that a file of any size is
// walked through in bounded memory. Move-only. Fails with kIo when the file cannot be opened or mapped. The
// file must not shrink while it is mapped.
class MappedFile {
 public:
  static Result<MappedFile> Open(const std::filesystem::path& path);

  LogBytes bytes() const { return {data_.get(), data_.get_deleter().size}; }
  // Drops the resident pages that lie wholly before `offset`; they are read again if touched again.
  void ReleaseBefore(std::size_t offset) const;

 private:
  struct Unmap {
    std::size_t size = 0;
    void operator()(const std::uint8_t* data) const;
  };
  MappedFile(const std::uint8_t* bytes, std::size_t size) : data_(bytes, Unmap{size}) {}
  std::unique_ptr<const std::uint8_t, Unmap> data_;
};

}  // namespace skyquilt::flight
