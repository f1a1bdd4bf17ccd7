// libFuzzer: any bytes as the text of a panel's code, and as the levels of a picture in which one is looked
// for. Checked: a reflectance read is one, and an area found lies within the picture.
#include <cstdint>
#include <cstring>

#include "core/bands/find_panel.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto code = skyquilt::bands::ParsePanelCode({reinterpret_cast<const char*>(bytes), size});
  if (code) {
    const auto share = code->ReflectanceAt(560.0);
    SKYQUILT_CHECK(!share || (*share > 0.0 && *share < 1.0), "no reflectance");
  }
  constexpr int kSide = 96;
  skyquilt::image::SampleImage picture{kSide, kSide, std::vector<std::uint16_t>(std::size_t{kSide} * kSide)};
  std::memcpy(picture.samples.data(), bytes, std::min(size, picture.samples.size() * 2));
  const auto found = skyquilt::bands::FindPanel(picture);
  if (found)
    SKYQUILT_CHECK(skyquilt::bands::LevelsIn(picture, found->area_px).has_value(), "an area outside");
  return 0;
}
