// Trace: what the program's threads do when, for a timeline: spans of one thread, and decisions with the
// numbers they were taken by, written as JSON in Chrome's trace event format, a line each (chrome://tracing,
// ui.perfetto.dev; "Trace Event Format", complete events "X" and instant events "i"). Nothing is collected
// until BeginTrace; before that each costs one load. At most a million are kept, the others are counted.
// Any thread.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace skyquilt {

void BeginTrace();

// The spans that have ended and the decisions, as one JSON document; collecting ends with it.
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

// Names must be literals that end with the number's unit; `item` says of what, a photo for example.
using TraceNumbers = std::initializer_list<std::pair<const char*, double>>;
void TraceDecision(const char* name, TraceNumbers numbers, std::string_view item = {});

}  // namespace skyquilt
