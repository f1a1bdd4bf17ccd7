// SHA-256 of bytes that come one after another, of blobs and of files. One thread per sum. Errors: kIo.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::storage {

class Sha256Sum {
 public:
  Sha256Sum();
  ~Sha256Sum();
  Sha256Sum(const Sha256Sum&) = delete;
  Sha256Sum& operator=(const Sha256Sum&) = delete;
  void Add(std::string_view bytes);
  // In hex; once.
  std::string Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string HexOf(std::span<const unsigned char> bytes);
std::string Sha256Hex(std::string_view bytes);

class BlobStore;
struct BlobInfo;

// As its place gives it back now, read in windows. Errors: those of the blob.
Result<std::string> Sha256OfBlob(BlobStore& blobs, const BlobInfo& blob);

Result<std::string> Sha256OfFile(const std::filesystem::path& path);

}  // namespace skyquilt::storage
