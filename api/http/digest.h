// Digest: SHA-256 (and, for protocols that ask for it, SHA-1) of bytes that come in pieces. One thread at a
// time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace skyquilt::api {

enum class DigestAlgorithm { kSha1, kSha256 };

class Digest {
 public:
  explicit Digest(DigestAlgorithm algorithm);
  ~Digest();
  Digest(Digest&&) noexcept;
  Digest& operator=(Digest&&) noexcept;
  void Add(std::span<const std::uint8_t> bytes);
  // The raw digest. Once.
  std::string Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// RFC 4648 with padding, strictly; absent when it is not that.
std::optional<std::string> DecodeBase64(std::string_view text);
std::string EncodeBase64(std::string_view bytes);

// Content-Digest of RFC 9530: the raw SHA-256 out of "sha-256=:...:" (others beside it are left alone);
// absent when the header has none.
std::optional<std::string> Sha256OfContentDigest(std::string_view header);

}  // namespace skyquilt::api
