// What an archive of tiles says of itself.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/check.h"
#include "storage/pmtiles/pmtiles_archive.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::storage;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto header = ParsePmtilesHeader(text);
  (void)ParsePmtilesMetadata(text, header ? *header : PmtilesHeader()).ok();
  // As it is, and as what a well-formed member holds: few inputs are one by themselves.
  for (const auto& directory : {ParsePmtilesDirectory(text), ParsePmtilesDirectory(Gzip(text))}) {
    if (!directory) continue;
    for (std::size_t i = 1; i < directory->size(); ++i)
      SKYQUILT_CHECK((*directory)[i - 1].tile < (*directory)[i].tile, "tiles out of order");
    for (const PmtilesEntry& entry : *directory) {
      const auto found = FindPmtilesEntry(*directory, entry.tile);
      SKYQUILT_CHECK(found && found->tile == entry.tile, "an entry that cannot be found");
    }
  }
  return 0;
}
