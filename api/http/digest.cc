#include "api/http/digest.h"

#include <openssl/evp.h>

#include <array>

#include "core/base/check.h"

namespace skyquilt::api {

struct Digest::State {
  State() : context(EVP_MD_CTX_new()) {}
  ~State() { EVP_MD_CTX_free(context); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  EVP_MD_CTX* context;
};

Digest::Digest(DigestAlgorithm algorithm) : state_(std::make_unique<State>()) {
  const EVP_MD* kind = algorithm == DigestAlgorithm::kSha1 ? EVP_sha1() : EVP_sha256();
  SKYQUILT_CHECK(EVP_DigestInit_ex(state_->context, kind, nullptr) == 1, "a digest that OpenSSL always has");
}
Digest::~Digest() = default;
Digest::Digest(Digest&&) noexcept = default;
Digest& Digest::operator=(Digest&&) noexcept = default;

void Digest::Add(std::span<const std::uint8_t> bytes) {
  SKYQUILT_CHECK(EVP_DigestUpdate(state_->context, bytes.data(), bytes.size()) == 1,
                 "a digest takes any bytes");
}

std::string Digest::Finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> raw{};
  unsigned int size = 0;
  SKYQUILT_CHECK(EVP_DigestFinal_ex(state_->context, raw.data(), &size) == 1, "a digest ends once");
  return std::string(raw.begin(), raw.begin() + size);
}

namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::optional<std::string> DecodeBase64(std::string_view text) {
  if (text.size() % 4 != 0) return std::nullopt;
  std::size_t padding = 0;
  while (padding < 2 && text.ends_with('=')) {
    text.remove_suffix(1);
    ++padding;
  }
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t value = kAlphabet.find(c);
    if (value == std::string_view::npos) return std::nullopt;
    bits = (bits << 6) | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>((bits >> count) & 0xff));
  }
  // One text a value: the bits left over are zero.
  if (count >= 6 || (bits & ((1U << count) - 1)) != 0) return std::nullopt;
  return bytes;
}

std::string EncodeBase64(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    const std::size_t taken = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      bits = (bits << 8) | (k < taken ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text.push_back(k <= taken ? kAlphabet[(bits >> (18 - 6 * k)) & 63] : '=');
    }
  }
  return text;
}

std::optional<std::string> Sha256OfContentDigest(std::string_view header) {
  while (!header.empty()) {
    const std::string_view item = header.substr(0, header.find(','));
    header.remove_prefix(std::min(item.size() + 1, header.size()));
    const std::size_t first = item.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    std::string_view member = item.substr(first, item.find_last_not_of(" \t") - first + 1);
    constexpr std::string_view kName = "sha-256=:";
    if (!member.starts_with(kName) || !member.ends_with(':') || member.size() == kName.size()) continue;
    member.remove_prefix(kName.size());
    member.remove_suffix(1);
    return DecodeBase64(member);
  }
  return std::nullopt;
}

}  // namespace skyquilt::api
