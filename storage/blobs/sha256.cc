#include "storage/blobs/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/blobs/blob_store.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {

struct Sha256Sum::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256Sum::Sha256Sum() : state_(std::make_unique<State>()) {
  SKYQUILT_CHECK(EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1, "OpenSSL has no SHA-256");
}

Sha256Sum::~Sha256Sum() = default;

void Sha256Sum::Add(std::string_view bytes) {
  SKYQUILT_CHECK(EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) == 1,
                 "OpenSSL failed to digest");
}

std::string Sha256Sum::Finish() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  SKYQUILT_CHECK(EVP_DigestFinal_ex(state_->context, digest, &length) == 1, "OpenSSL failed to digest");
  return HexOf({digest, length});
}

std::string HexOf(std::span<const unsigned char> bytes) {
  std::string hex;
  for (const unsigned char byte : bytes) hex += fmt::format("{:02x}", byte);
  return hex;
}

std::string Sha256Hex(std::string_view bytes) {
  Sha256Sum sum;
  sum.Add(bytes);
  return sum.Finish();
}

Result<std::string> Sha256OfBlob(BlobStore& blobs, const BlobInfo& blob) {
  constexpr std::int64_t kWindow = std::int64_t{8} << 20;
  Sha256Sum sum;
  for (std::int64_t at = 0; at < blob.bytes; at += kWindow) {
    SKYQUILT_TRY_ASSIGN(const std::string bytes,
                        blobs.ReadRange(blob.key, at, std::min(kWindow, blob.bytes - at)));
    sum.Add(bytes);
  }
  return sum.Finish();
}

Result<std::string> Sha256OfFile(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  Sha256Sum sum;
  std::string slice(std::size_t{1} << 20, '\0');
  while (file) {
    file.read(slice.data(), static_cast<std::streamsize>(slice.size()));
    sum.Add(std::string_view(slice).substr(0, static_cast<std::size_t>(file.gcount())));
  }
  if (!file.eof()) return FileError("cannot read", path, errno != 0 ? errno : EIO);
  return sum.Finish();
}

}  // namespace skyquilt::storage
