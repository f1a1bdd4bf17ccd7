// libFuzzer: any text taken for the report of a map that is imported. Checked: a quality that is taken can be
// written and read again.
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "server/imports/told_quality.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  pipeline::MosaicReport imported;
  imported.gsd_m = 1e6;  // any bounds but the wildest are within two pixels
  for (const bool is_of_tiles : {false, true}) {
    const auto told = server::ToldOfMap({reinterpret_cast<const char*>(data), size}, imported, is_of_tiles);
    if (!told) continue;
    const auto again = pipeline::ParseQuality(pipeline::QualityJson(told->quality));
    SKYQUILT_CHECK(again.ok() && *again == told->quality, "a quality that is read as another");
  }
  return 0;
}
