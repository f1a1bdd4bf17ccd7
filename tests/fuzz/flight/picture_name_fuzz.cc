// libFuzzer: any bytes as a picture's name. Checked: each mark of a copy that is taken off makes it shorter,
// and a lens's mark stands at its end.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/aside/picture_name.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  namespace flight = skyquilt::flight;
  constexpr std::size_t kLongestName = 4096;
  const std::string_view name(reinterpret_cast<const char*>(bytes),
                              size < kLongestName ? size : kLongestName);
  std::string stem = flight::PictureNameOf(name).stem;
  SKYQUILT_CHECK(stem.ends_with(flight::LensMark(stem)), "a mark that is not there");
  SKYQUILT_CHECK(!flight::AreOfOneCounter(stem, stem), "two exposures of one name");
  while (const auto next = flight::WithoutCopyMark(stem)) {
    SKYQUILT_CHECK(!next->stem.empty() && next->stem.size() < stem.size(), "a mark that takes nothing off");
    stem = next->stem;
  }
  return 0;
}
