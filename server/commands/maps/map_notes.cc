#include "server/commands/maps/map_notes.h"

#include <fmt/core.h>

#include "core/base/text/printable.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::server {

void PrintNotes(const pipeline::MosaicReport& report) {
  for (const std::string& warning : flight::InWords(report.warnings))
    fmt::print("  note: {}\n", Printable(warning));
  for (const pipeline::MapLimit& limit : report.quality.limits)
    fmt::print("  limit: {}\n", pipeline::LimitInWords(limit));
}

std::string SizeInWords(const pipeline::MosaicReport& report) {
  if (report.quality.IsLimitedBy(pipeline::LimitKind::kScaleGuessed)) return "size unknown";
  return fmt::format("{:.2f} ha at {:.1f} cm a pixel", report.area_m2 / 1e4, report.gsd_m * 100.0);
}

}  // namespace skyquilt::server
