// Trace: what the program's threads do when, for a timeline: spans of one thread, written as JSON in Chrome's
// trace event format (chrome://tracing, ui.perfetto.dev; "Trace Event Format", complete events "X"). Nothing
// is collected until BeginTrace; before that a span costs one load. At most kMaxTraceSpans are kept, the
// others are counted. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace skyquilt {

inline constexpr std::size_t kMaxTraceSpans = 1'000'000;

void BeginTrace();

// The spans that have ended, as one JSON document; collecting ends with it.
std::string EndTrace();

// From here to the end of the scope. `name` must be a literal; `item` says of what, a photo for example.
class TraceSpan {
 public:
  explicit TraceSpan(const char* name, std::string_view item = {});
  ~TraceSpan();
  TraceSpan(const TraceSpan&) = delete;
  TraceSpan& operator=(const TraceSpan&) = delete;

 private:
  const char* name_;
  std::int64_t begun_us_ = -1;  // below 0: nothing is collected
  std::string item_;
};

}  // namespace skyquilt
