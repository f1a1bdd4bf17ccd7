#include "core/flight/bytes/log_text.h"

#include <algorithm>
#include <optional>

#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxUtf16Bytes = std::size_t{64} << 20;

struct Utf16 {
  bool is_big_endian = false;
  std::size_t begin = 0;  // behind the byte-order mark
};

// Without a mark: at least 16 bytes, of which one of each two is zero and the other a letter of text.
std::optional<Utf16> RecogniseUnmarked(LogBytes bytes) {
  constexpr std::size_t kMinBytes = 16, kLooked = 256;
  if (bytes.size() < kMinBytes) return std::nullopt;
  const std::size_t looked = std::min(bytes.size(), kLooked) / 2 * 2;
  for (const bool is_big_endian : {false, true}) {
    bool fits = true;
    for (std::size_t i = 0; i < looked && fits; i += 2) {
      const std::uint8_t low = bytes[i + (is_big_endian ? 1 : 0)];
      const std::uint8_t high = bytes[i + (is_big_endian ? 0 : 1)];
      fits = high == 0 && (low >= 0x20 || (low >= 0x09 && low <= 0x0D));
    }
    if (fits) return Utf16{is_big_endian, 0};
  }
  return std::nullopt;
}

std::optional<Utf16> RecogniseUtf16(LogBytes bytes) {
  if (bytes.size() >= 4 && bytes[0] == 0xFF && bytes[1] == 0xFE && (bytes[2] != 0 || bytes[3] != 0))
    return Utf16{false, 2};  // with two zeros behind it, it is UTF-32
  if (bytes.size() >= 4 && bytes[0] == 0xFE && bytes[1] == 0xFF) return Utf16{true, 2};
  return RecogniseUnmarked(bytes);
}

void AppendUtf8(std::uint32_t code, std::string& text) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(static_cast<std::uint8_t>(byte)); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0U | (code >> 6U));
  } else {
    if (code < 0x10000) {
      put(0xE0U | (code >> 12U));
    } else {
      put(0xF0U | (code >> 18U));
      put(0x80U | ((code >> 12U) & 0x3FU));
    }
    put(0x80U | ((code >> 6U) & 0x3FU));
  }
  put(0x80U | (code & 0x3FU));
}

std::string DecodeUtf16(LogBytes bytes, const Utf16& kind) {
  const auto unit_at = [&](std::size_t i) {
    const std::uint32_t first = bytes[i], second = bytes[i + 1];
    return kind.is_big_endian ? (first << 8U) | second : (second << 8U) | first;
  };
  constexpr std::uint32_t kReplacement = 0xFFFD;
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = kind.begin; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit_at(i);
    if (code >= 0xD800 && code < 0xE000) {
      const std::uint32_t next = i + 3 < bytes.size() ? unit_at(i + 2) : 0;
      const bool is_pair = code < 0xDC00 && next >= 0xDC00 && next < 0xE000;
      code = is_pair ? 0x10000U + ((code - 0xD800U) << 10U) + (next - 0xDC00U) : kReplacement;
      if (is_pair) i += 2;
    }
    AppendUtf8(code, text);
  }
  return text;
}

}  // namespace

Result<LogText> LogText::Of(std::string_view name, LogBytes bytes) {
  LogText text;
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  text.raw_ = TextOf(bytes).starts_with(kUtf8Mark) ? bytes.subspan(kUtf8Mark.size()) : bytes;
  const auto kind = RecogniseUtf16(bytes);
  if (!kind) return text;
  if (bytes.size() > kMaxUtf16Bytes) {
    return Because(
        ErrorCode::kUnsupportedFormat,
        {RemarkCode::kTextTooLarge,
         {{"file", name}, {"size_mib", bytes.size() >> 20U}, {"most_mib", kMaxUtf16Bytes >> 20U}}});
  }
  text.decoded_ = DecodeUtf16(bytes, *kind);
  text.is_decoded_ = true;
  return text;
}

}  // namespace skyquilt::flight
