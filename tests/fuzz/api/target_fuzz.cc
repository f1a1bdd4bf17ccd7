// Request targets and tile paths: no crash, and nothing that could climb out of a folder comes through.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "api/http/target.h"
#include "api/tiles/tile_path.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto target = skyquilt::api::ParseTarget(text);
  if (!target) return 0;
  for (const std::string& segment : target->segments) {
    SKYQUILT_CHECK(!segment.empty() && segment != "." && segment != "..", "a segment means a folder");
    for (const char c : segment) {
      SKYQUILT_CHECK(c != '/' && c != '\\' && static_cast<unsigned char>(c) >= 0x20,
                     "a segment holds a path");
    }
  }
  if (target->segments.size() >= 3) {
    const auto tile =
        skyquilt::api::ParseTilePath(target->segments[0], target->segments[1], target->segments[2]);
    if (tile) SKYQUILT_CHECK(tile->tile.z() <= 30 && (tile->tile.x() >> tile->tile.z()) == 0, "no such tile");
  }
  return 0;
}
