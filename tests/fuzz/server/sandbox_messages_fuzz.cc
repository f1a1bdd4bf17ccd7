// What a sandboxed process says: no crash, and what is believed can be said again.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "server/jobs/child_messages.h"
#include "server/reports/map_picture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::server;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  if (const auto message = ParseJobMessage(text))
    SKYQUILT_CHECK(ParseJobMessage(ToText(*message)).ok(), "a message was believed that we would not send");
  if (const auto message = ParsePreviewMessage(text))
    SKYQUILT_CHECK(ParsePreviewMessage(ToText(*message)).ok(),
                   "a message was believed that we would not send");
  if (const auto pixels = ParseMapPixels(text))
    SKYQUILT_CHECK(ParseMapPixels(ToBytes(*pixels)).ok(), "pixels were believed that we would not send");
  return 0;
}
