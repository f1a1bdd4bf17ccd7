// RemarkCode: what a remark (remark.h) says, without its values. The codes stand in remarks_on_*.inc, each
// with its name in JSON and its English sentence; words for the page stand in web/src/languages/*/remarks.js
// and failures.js, which tests/web/languages/remarks.test.js holds to these lists. Any thread.
#pragma once

#include <cstdint>

namespace skyquilt::flight {

enum class RemarkCode : std::uint16_t {
#define REMARK(code, ...) code,
#include "core/flight/remarks/remarks.inc"
#undef REMARK
};

}  // namespace skyquilt::flight
