// Digests of bytes that come one after another, of blobs and of files, and how they are written as text:
// OpenSSL's. One thread per sum. Errors: kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

struct evp_md_ctx_st;

namespace skyquilt::storage {

// Others than SHA-256 are for protocols that ask for them.
enum class DigestAlgorithm { kMd5, kSha1, kSha256 };

class RawDigest {
 public:
  explicit RawDigest(DigestAlgorithm algorithm);
  void Add(std::string_view bytes);
  void Add(std::span<const std::uint8_t> bytes) {
    Add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  // The digest's own bytes; once.
  std::string Finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

// All at once, its own bytes.
std::string RawDigestOf(DigestAlgorithm algorithm, std::string_view bytes);
std::string HmacSha256(std::string_view key, std::string_view text);

std::string HexOf(std::string_view bytes);
// RFC 4648 with padding, strictly; absent when it is not that.
std::optional<std::string> DecodeBase64(std::string_view text);
std::string EncodeBase64(std::string_view bytes);

class Sha256Sum {
 public:
  void Add(std::string_view bytes) { digest_.Add(bytes); }
  // In hex; once.
  std::string Finish() { return HexOf(digest_.Finish()); }

 private:
  RawDigest digest_{DigestAlgorithm::kSha256};
};

std::string Sha256Hex(std::string_view bytes);

class BlobStore;
struct BlobInfo;

// As its place gives it back now, read in windows. Errors: those of the blob.
Result<std::string> Sha256OfBlob(BlobStore& blobs, const BlobInfo& blob);

Result<std::string> Sha256OfFile(const std::filesystem::path& path);

}  // namespace skyquilt::storage
