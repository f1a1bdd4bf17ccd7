// The headers of resumable uploads: what is read is read the same again.
#include <cstdint>
#include <string>
#include <string_view>

#include "api/uploads/tus_headers.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::api;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto number = ParseTusNumber(text)) {
    SKYQUILT_CHECK(*number >= 0 && *number <= (std::int64_t{1} << 53), "a length outside what JSON can say");
  }
  if (const auto metadata = ParseTusMetadata(text)) {
    std::string again;
    for (const auto& [key, value] : *metadata) {
      again += (again.empty() ? "" : ",") + key + (value.empty() ? "" : " " + EncodeBase64(value));
    }
    SKYQUILT_CHECK(again.size() > 8192 || ParseTusMetadata(again) == metadata,
                   "metadata that change when sent back");
  }
  if (const auto checksum = ParseTusChecksum(text)) {
    SKYQUILT_CHECK(checksum->digest.size() == 20 || checksum->digest.size() == 32,
                   "a digest of no algorithm's size");
  }
  if (const auto bytes = DecodeBase64(text)) {
    SKYQUILT_CHECK(EncodeBase64(*bytes) == text, "two texts for the same bytes");
  }
  (void)Sha256OfContentDigest(text);
  return 0;
}
