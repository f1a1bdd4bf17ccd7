// ToldQuality: what the text of the report.json that came with a map's file says of its quality; nothing
// where it is the report of another map, or none that can be read. It belongs to the map where it names the
// same bounds, to a tenth of a millimetre for tiles, which are taken over as they are, and to two pixels for
// a raster, and for tiles as many of the same size and zooms. Foreign bytes. Pure; any thread; never fails.
#pragma once

#include <optional>
#include <string_view>

#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

std::optional<pipeline::MapQuality> ToldQuality(std::string_view report_json,
                                                const pipeline::MosaicReport& imported, bool is_of_tiles);

}  // namespace skyquilt::server
