// libFuzzer: any bytes as the head of a table that no reader knows. Checked: what is said of it is bounded.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/logs/csv/unknown_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto words = skyquilt::flight::ExplainUnknownTable({bytes, size}, "fuzz.csv");
  SKYQUILT_CHECK(!words || words->size() < 2000, "an endless explanation");
  return 0;
}
