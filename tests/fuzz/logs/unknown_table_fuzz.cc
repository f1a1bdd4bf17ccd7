// libFuzzer: any bytes as the head of a table or list that no reader knows. Checked: what is said of it is
// bounded.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/logs/explain_unknown.h"
#include "core/flight/remarks/remark_words.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto words = skyquilt::flight::ExplainUnknownTable({bytes, size}, "fuzz.csv");
  SKYQUILT_CHECK(!words || skyquilt::flight::InWords(*words).size() < 2000, "an endless explanation");
  const auto list = skyquilt::flight::ExplainUnknownList({bytes, size}, "fuzz.txt");
  SKYQUILT_CHECK(!list || skyquilt::flight::InWords(*list).size() < 2000, "an endless explanation");
  return 0;
}
