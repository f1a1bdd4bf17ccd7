#include "storage/blobs/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/blobs/blob_store.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

// Each found once: otherwise OpenSSL looks for it, under its locks, at the beginning of every digest.
const EVP_MD* KindOf(DigestAlgorithm algorithm) {
  static const EVP_MD* const md5 = EVP_MD_fetch(nullptr, "MD5", nullptr);
  static const EVP_MD* const sha1 = EVP_MD_fetch(nullptr, "SHA1", nullptr);
  static const EVP_MD* const sha256 = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  return algorithm == DigestAlgorithm::kMd5 ? md5 : algorithm == DigestAlgorithm::kSha1 ? sha1 : sha256;
}

}  // namespace

RawDigest::RawDigest(DigestAlgorithm algorithm) : context_(EVP_MD_CTX_new()) {
  SKYQUILT_CHECK(EVP_DigestInit_ex(context_.get(), KindOf(algorithm), nullptr) == 1,
                 "a digest that OpenSSL always has");
}

void RawDigest::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

void RawDigest::Add(std::string_view bytes) {
  SKYQUILT_CHECK(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1,
                 "a digest takes any bytes");
}

std::string RawDigest::Finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> raw{};
  unsigned int size = 0;
  SKYQUILT_CHECK(EVP_DigestFinal_ex(context_.get(), raw.data(), &size) == 1, "a digest ends once");
  return {raw.begin(), raw.begin() + size};
}

std::string RawDigestOf(DigestAlgorithm algorithm, std::string_view bytes) {
  RawDigest digest(algorithm);
  digest.Add(bytes);
  return digest.Finish();
}

std::string HmacSha256(std::string_view key, std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> mac{};
  unsigned int size = 0;
  SKYQUILT_CHECK(
      HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
           reinterpret_cast<const unsigned char*>(text.data()), text.size(), mac.data(), &size) != nullptr,
      "OpenSSL has no HMAC-SHA256");
  return {mac.begin(), mac.begin() + size};
}

std::string HexOf(std::string_view bytes) {
  std::string hex;
  for (const char byte : bytes) hex += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return hex;
}

std::optional<std::string> DecodeBase64(std::string_view text) {
  std::string bytes(text.size() / 4 * 3, '\0');
  const int size =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  if (size < 0) return std::nullopt;
  const int padding = text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
  bytes.resize(static_cast<std::size_t>(std::max(0, size - padding)));
  // OpenSSL passes over blanks around it and bits that are left over: here a value has one text.
  if (EncodeBase64(bytes) != text) return std::nullopt;
  return bytes;
}

std::string EncodeBase64(std::string_view bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // OpenSSL puts a zero behind it
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                  reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.pop_back();
  return text;
}

std::string Sha256Hex(std::string_view bytes) { return HexOf(RawDigestOf(DigestAlgorithm::kSha256, bytes)); }

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
