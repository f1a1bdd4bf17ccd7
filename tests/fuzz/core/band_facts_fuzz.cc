// libFuzzer: any bytes as a photo of one band, and as the lists of its sunshine sensor. Checked: what is read
// makes numbers of levels.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/bands/band_facts.h"
#include "core/bands/read_radiometry.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  flight::MemoryBytes source({bytes, size});
  if (const auto facts = bands::ReadBandFacts(source)) {
    SKYQUILT_CHECK(!facts->name.empty(), "a band without a name");
    SKYQUILT_CHECK(std::isfinite(facts->radiometry.per_level), "levels without a value");
    SKYQUILT_CHECK(facts->radiometry.vignetting.Gain(3.0, 4.0, 8, 6) >= 0.1, "a lens without light");
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  if (const auto records = bands::ReadIrradianceList(text))
    SKYQUILT_CHECK(bands::LastCounts(*records) > 0.0, "sunshine without light");
  if (const auto counts = bands::CalibrationCounts(text))
    SKYQUILT_CHECK(std::isfinite(*counts) && *counts > 0.0, "a calibration without light");
  return 0;
}
