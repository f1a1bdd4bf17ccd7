// What a command says of the map that it made. Main thread.
#pragma once

#include <string>

#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

// A line each on standard output: what was noted while it was made or placed, then what limits it.
void PrintNotes(const pipeline::MosaicReport& report);

// "1.20 ha at 2.3 cm a pixel"; "size unknown".
std::string SizeInWords(const pipeline::MosaicReport& report);

}  // namespace skyquilt::server
