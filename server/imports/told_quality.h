// ToldOfMap: what the text of the report.json that came with a map's file says of it; nothing where it is the
// report of another map, or none that can be read. It belongs to the map where it names the same bounds, to a
// tenth of a millimetre for tiles, which are taken over as they are, and to two pixels for a raster, and for
// tiles as many of the same size and zooms. Foreign bytes, read in bounded memory. Pure; any thread; never
// fails.
#pragma once

#include <optional>
#include <string_view>

#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

struct Told {
  pipeline::MapQuality quality;
  double gsd_m = 0.0, area_m2 = 0.0;  // of a raster those of its pixels
};

std::optional<Told> ToldOfMap(std::string_view report_json, const pipeline::MosaicReport& imported,
                              bool is_of_tiles);

// Whether it is one of a map of ours at all.
bool IsReportOfAMap(std::string_view report_json);

}  // namespace skyquilt::server
