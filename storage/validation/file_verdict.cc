#include "storage/validation/file_verdict.h"

#include <fmt/format.h>

#include <algorithm>

namespace skyquilt::storage {

const char* SeverityName(Severity severity) {
  return severity == Severity::kError ? "error" : severity == Severity::kWarning ? "warning" : "note";
}

bool FileVerdict::Has(Severity severity) const {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.severity == severity; });
}

void CountedFindings::Add(Severity severity, const std::string& kind, const std::string& example) {
  constexpr std::size_t kExamples = 3;
  Counted& counted = counted_[{severity, kind}];
  ++counted.count;
  if (counted.first.size() < kExamples) counted.first.push_back(example);
}

void CountedFindings::MoveTo(FileVerdict& verdict) {
  for (const auto& [what, counted] : counted_) {
    std::string examples;
    for (const std::string& example : counted.first) examples += (examples.empty() ? "" : ", ") + example;
    verdict.Add(what.first, fmt::format("{} {} ({}{})", counted.count, what.second, examples,
                                        counted.count > std::ssize(counted.first) ? ", ..." : ""));
  }
  counted_.clear();
}

}  // namespace skyquilt::storage
