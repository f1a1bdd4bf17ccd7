// libFuzzer: any bytes as a list of known reflectances. Checked: what is read is within its rules.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/lists/reflectance_list.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto list =
      skyquilt::flight::ParseReflectanceList("fuzz.csv", {reinterpret_cast<const char*>(bytes), size});
  if (!list) return 0;
  for (const auto& target : list->targets) {
    SKYQUILT_CHECK(target.radius_m > 0.0 && target.radius_m <= 1000.0, "a target without an area");
    SKYQUILT_CHECK(target.reflectance.all || !target.reflectance.bands.empty(), "a target that says nothing");
  }
  for (const auto& panel : list->panels) {
    SKYQUILT_CHECK(!panel.photo.empty(), "a panel in no photo");
    SKYQUILT_CHECK(!panel.box_px || (*panel.box_px)[0] < (*panel.box_px)[2], "a panel without an area");
  }
  return 0;
}
