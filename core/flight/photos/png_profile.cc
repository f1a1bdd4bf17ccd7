#include "core/flight/photos/png_profile.h"

#include <zlib.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "core/base/text/plain_text.h"
#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {
namespace {

constexpr std::string_view kProfileKeys[] = {"Raw profile type exif", "Raw profile type APP1",
                                             "Raw profile type xmp"};
constexpr std::size_t kMaxProfileText = 256u << 10;

// As text; empty for what is damaged or longer than it may be.
std::string Inflated(std::span<const std::uint8_t> bytes) {
  std::string text(kMaxProfileText, '\0');
  auto size = static_cast<uLongf>(text.size());
  if (uncompress(reinterpret_cast<Bytef*>(text.data()), &size, bytes.data(),
                 static_cast<uLong>(bytes.size())) != Z_OK)
    return "";
  text.resize(size);
  return text;
}

// A line with its name, one with its length, then its bytes two digits each in lines.
std::string BytesOfProfile(std::string_view text) {
  constexpr std::string_view kBlanks = " \n\r\t", kDigits = "0123456789";
  const auto skip = [&](std::size_t end) { text.remove_prefix(std::min(end, text.size())); };
  skip(text.find_first_not_of(kBlanks));
  skip(text.find('\n'));
  skip(text.find_first_not_of(kBlanks));
  skip(text.find_first_not_of(kDigits));
  std::string bytes;
  int high = -1;
  for (const char c : text) {
    if (kBlanks.find(c) != std::string_view::npos) continue;
    const int digit = HexDigit(c);
    if (digit < 0) return "";
    if (high >= 0) bytes.push_back(static_cast<char>(16 * high + digit));
    high = high < 0 ? digit : -1;
  }
  return bytes;
}

}  // namespace

bool IsPngProfile(std::span<const std::uint8_t> start) {
  const std::string_view text = TextOf(start);
  return std::any_of(std::begin(kProfileKeys), std::end(kProfileKeys), [&](std::string_view key) {
    return text.starts_with(key) && text.size() > key.size() && text[key.size()] == '\0';
  });
}

PngProfile ReadPngProfile(std::span<const std::uint8_t> chunk, bool is_compressed) {
  if (!IsPngProfile(chunk)) return {};
  const std::size_t head =
      TextOf(chunk).find('\0') + (is_compressed ? 2 : 1);  // and the method, always zlib's
  if (head >= chunk.size()) return {};
  const auto body = chunk.subspan(head);
  if (!is_compressed && body.size() > kMaxProfileText) return {};
  const std::string bytes = BytesOfProfile(is_compressed ? Inflated(body) : std::string(TextOf(body)));
  constexpr std::string_view kExif("Exif\0\0", 6), kXmp("http://ns.adobe.com/xap/1.0/\0", 29);
  PngProfile profile;
  if (bytes.starts_with(kExif)) {
    profile.exif.assign(bytes.begin() + kExif.size(), bytes.end());
  } else if (bytes.starts_with("II") || bytes.starts_with("MM")) {
    profile.exif.assign(bytes.begin(), bytes.end());
  } else {
    profile.xmp = bytes.starts_with(kXmp) ? bytes.substr(kXmp.size()) : bytes;
  }
  return profile;
}

}  // namespace skyquilt::flight
