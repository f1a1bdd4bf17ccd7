#include "server/commands/maps/map_notes.h"

#include <fmt/core.h>

#include <string>

#include "core/base/text/printable.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::server {

void PrintNotes(const pipeline::MosaicReport& report) {
  for (const std::string& warning : flight::InWords(report.warnings))
    fmt::print("  note: {}\n", Printable(warning));
  for (const pipeline::MapLimit& limit : report.quality.limits)
    fmt::print("  limit: {}\n", pipeline::LimitInWords(limit));
}

}  // namespace skyquilt::server
