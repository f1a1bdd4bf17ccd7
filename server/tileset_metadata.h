// TilesetMetadataOf: what a map's tileset says of itself, by the map's report. Pure.
#pragma once

#include "core/pipeline/report/mosaic_report.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::server {

// Of a map of photos; the caller says what is otherwise.
storage::TilesetMetadata TilesetMetadataOf(const pipeline::MosaicReport& report);

}  // namespace skyquilt::server
