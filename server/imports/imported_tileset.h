// What an imported tileset says of itself. Pure.
#pragma once

#include <string>

#include "core/pipeline/report/mosaic_report.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::server {

storage::TilesetMetadata MetadataOfImport(const pipeline::MosaicReport& report,
                                          const std::string& attribution);

}  // namespace skyquilt::server
