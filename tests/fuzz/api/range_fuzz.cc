// The Range header: whatever is asked, the part lies inside the body.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "api/http/conditional.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::uint64_t length = 0;
  if (size < sizeof length) return 0;
  std::memcpy(&length, bytes, sizeof length);
  const std::string_view header(reinterpret_cast<const char*>(bytes) + sizeof length, size - sizeof length);
  const auto range = skyquilt::api::ParseRange(header, length);
  if (range.kind == skyquilt::api::RangeKind::kPart) {
    SKYQUILT_CHECK(range.length > 0 && range.first < length && range.length <= length - range.first,
                   "outside");
  }
  static_cast<void>(skyquilt::api::EtagListMatches(header, "\"a\""));
  return 0;
}
