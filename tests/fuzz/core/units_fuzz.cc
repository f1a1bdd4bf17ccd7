// libFuzzer: any bytes taken for what another process found in photos, or placed of a flight. Checked: they
// are refused, or written and read again as the same.
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/check.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/units/map_units.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::pipeline;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 3 == 0) {
    FoundFiles found, again;
    if (!ParseFound(bytes, found)) return 0;
    const std::string written = WriteFound(found);
    SKYQUILT_CHECK(ParseFound(written, again).ok(), "what was found is refused");
    SKYQUILT_CHECK(WriteFound(again) == written, "what was found is read as something else");
  } else if (data[0] % 3 == 1) {
    const auto shown = ParseShown(bytes);
    if (!shown) return 0;
    const std::string written = WriteShown(*shown);
    const auto again = ParseShown(written);
    SKYQUILT_CHECK(again.ok() && WriteShown(*again) == written, "shown photos are read as others");
    SKYQUILT_CHECK(shown->NamesIn({0, shown->of_blocks.size()}).size() <= shown->names.size(),
                   "more photos are shown than there are");
  } else {
    const auto facts = ParseFacts(bytes);
    if (!facts) return 0;
    SKYQUILT_CHECK(DigestsOfFacts(bytes).ok(), "the files of facts that can be read");
    const std::string written = WriteFacts(*facts);
    const auto again = ParseFacts(written);
    SKYQUILT_CHECK(again.ok() && WriteFacts(*again) == written, "facts are read as others");
  }
  return 0;
}
