#include "server/tileset_metadata.h"

#include <string>

namespace skyquilt::server {

storage::TilesetMetadata TilesetMetadataOf(const pipeline::MosaicReport& report) {
  storage::TilesetMetadata metadata;
  metadata.name = report.title.empty() ? "Skyquilt map" : report.title;
  metadata.description =
      "Orthomosaic of " + std::to_string(report.photos_aligned + report.photos_pose_only) + " aerial photos";
  metadata.bounds = report.bounds;
  metadata.min_zoom = report.min_zoom;
  metadata.max_zoom = report.max_zoom;
  metadata.tile_size_px = report.tile_size_px;
  metadata.generator = "Skyquilt";
  return metadata;
}

}  // namespace skyquilt::server
