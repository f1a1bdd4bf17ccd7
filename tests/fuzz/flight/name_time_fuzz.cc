// libFuzzer: any bytes as a file's name. Checked: a time found is one of this era, and the same name says the
// same again.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/metadata/capture_time.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view name(reinterpret_cast<const char*>(bytes), size);
  const auto found = skyquilt::flight::TimeInName(name);
  if (!found) return 0;
  constexpr std::int64_t kYear1990 = 631'152'000'000'000, kYear2101 = 4'133'980'800'000'000;
  const std::int64_t micros = found->time.time_since_epoch().count();
  SKYQUILT_CHECK(micros >= kYear1990 && micros < kYear2101, "a time of another era");
  SKYQUILT_CHECK(skyquilt::flight::TimeInName(name)->time == found->time, "another time of the same name");
  return 0;
}
