// RemarkCode: what a remark (remark.h) says, without its values. The codes stand in codes_on_*.inc, each with
// its English sentence in sentences_on_*.h, in the same order, and words for the page in
// web/src/languages/*/remarks.js and failures.js; tests/web/languages/remarks.test.js holds all of them to
// these lists. Any thread.
#pragma once

#include <cstdint>

namespace skyquilt::flight {

enum class RemarkCode : std::uint16_t {
#include "core/flight/remarks/codes_on_attempts.inc"
#include "core/flight/remarks/codes_on_deliverables.inc"
#include "core/flight/remarks/codes_on_failures.inc"
#include "core/flight/remarks/codes_on_files.inc"
#include "core/flight/remarks/codes_on_inputs.inc"
#include "core/flight/remarks/codes_on_logs.inc"
#include "core/flight/remarks/codes_on_maps.inc"
  kCount
};

}  // namespace skyquilt::flight
