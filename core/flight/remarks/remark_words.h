// Sentences of remarks, for reports and terminals, and names of their codes, for JSON. Pure; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// A code's name and its sentence, whose values stand in braces as fmt has them; `{x_m:length}` is "1.3 m" or
// "12 km", `{x_s:duration}` "90 seconds" or "12 minutes". `one` is said where the value `counted` is 1.
struct RemarkSentence {
  RemarkCode code;
  std::string_view name;
  std::string_view sentence;
  std::string_view counted = {};
  std::string_view one = {};
};
// In the order of the codes.
std::span<const RemarkSentence> RemarkSentences();

std::string_view NameOf(RemarkCode code);  // "no_ties"
std::optional<RemarkCode> RemarkCodeOf(std::string_view name);

// Where values are missing or of another kind, the code's name.
std::string InWords(const Remark& remark);
std::vector<std::string> InWords(const std::vector<Remark>& remarks);
std::string InOneLine(const std::vector<Remark>& remarks);  // one after the other, with semicolons

// One remark that says all of them, one sentence after the other.
Remark InARow(std::vector<Remark> remarks);

// "12.3 m", "1,234 m", "12 km".
std::string LengthInWords(double metres);

}  // namespace skyquilt::flight
