// libFuzzer: any bytes as the record of a thermal camera, alone and as a JPEG that carries it. Checked: what
// is read has levels, and temperatures are numbers within range or none.
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/bands/band_facts.h"
#include "core/bands/thermal.h"
#include "core/base/check.h"
#include "core/flight/photos/photo_decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  if (const auto record = flight::ReadFlirRecord({bytes, size})) {
    SKYQUILT_CHECK(record->width_px > 0 && record->height_px > 0 && !record->picture.empty(),
                   "a record without levels");
    if (const auto radiometry = bands::FlirTemperature(record->constants)) {
      for (const double level : {0.0, 10'000.0, 65'535.0}) {
        const double kelvin = radiometry->planck->KelvinOf(level);
        SKYQUILT_CHECK(std::isnan(kelvin) || (kelvin > 0.0 && kelvin < 5000.0), "no temperature");
      }
    }
  }
  // A picture with the bytes as its record, of a thermal camera's size.
  constexpr int kWidthPx = 160, kHeightPx = 120;
  constexpr std::size_t kMaxPart = 60'000;
  const std::size_t part = size < kMaxPart ? size : kMaxPart;
  std::vector<std::uint8_t> jpeg{0xFF,
                                 0xD8,
                                 0xFF,
                                 0xE1,
                                 static_cast<std::uint8_t>((part + 10) >> 8),
                                 static_cast<std::uint8_t>(part + 10),
                                 'F',
                                 'L',
                                 'I',
                                 'R',
                                 0,
                                 1,
                                 0,
                                 0};
  jpeg.insert(jpeg.end(), bytes, bytes + part);
  const std::vector<std::uint8_t> rest{0xFF, 0xC0, 0, 11,   8,    0, kHeightPx, 0,    kWidthPx, 1,
                                       1,    0x11, 0, 0xFF, 0xDA, 0, 2,         0xFF, 0xD9};
  jpeg.insert(jpeg.end(), rest.begin(), rest.end());
  flight::MemoryBytes source(jpeg);
  const auto facts = bands::ReadBandFacts(source);
  const bool is_thermal = facts.ok() && facts->name == "lwir";
  SKYQUILT_CHECK(is_thermal == (part > 0), "a thermal picture without its band, or one without a record");
  const auto levels = flight::DecodeSampleBytes(jpeg, kWidthPx, kHeightPx);
  SKYQUILT_CHECK(!levels || levels->samples.size() == std::size_t{kWidthPx} * kHeightPx,
                 "levels of another size");
  return 0;
}
