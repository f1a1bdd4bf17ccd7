#include "core/flight/metadata/base64.h"

namespace skyquilt::flight {
namespace {

// What stands for 6 bits; -1 for anything else.
int SixBits(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

}  // namespace

std::optional<std::vector<std::uint8_t>> FromBase64(std::string_view text, std::size_t max_bytes) {
  if (text.size() > 2 * max_bytes + 4) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  std::uint32_t kept = 0;
  int bits = 0;
  bool has_ended = false;
  for (const char c : text) {
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
    if (c == '=') {
      has_ended = true;
      continue;
    }
    const int six = SixBits(c);
    if (six < 0 || has_ended) return std::nullopt;
    kept = (kept << 6) | static_cast<std::uint32_t>(six);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    if (bytes.size() == max_bytes) return std::nullopt;
    bytes.push_back(static_cast<std::uint8_t>(kept >> bits));
  }
  return bytes;
}

}  // namespace skyquilt::flight
