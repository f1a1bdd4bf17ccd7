// PercentEncoded, PercentByte: bytes in addresses and headers as "%2F" (RFC 3986). Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "core/base/text/plain_text.h"

namespace skyquilt {

// All but letters, digits and what `plain` has.
inline std::string PercentEncoded(std::string_view text, std::string_view plain) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (IsLetterOrDigit(c) || plain.find(c) != std::string_view::npos) {
      encoded += c;
    } else {
      encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return encoded;
}

// What the "%2F" at the front of `text` stands for; negative where it begins otherwise.
inline int PercentByte(std::string_view text) {
  if (text.size() < 3 || text.front() != '%') return -1;
  const int high = HexDigit(text[1]), low = HexDigit(text[2]);
  return high < 0 || low < 0 ? -1 : high * 16 + low;
}

}  // namespace skyquilt
