// PreviewCanvas: composes photos onto the tiles of a growing preview and updates the overviews above changed
// tiles. Reads the tiles it needs and writes nothing: Finish returns what the next edition changes. One
// thread; memory: the changed tiles, decoded. Errors: kCorrupt (a stored tile), kIo.
#pragma once

#include <map>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/rgba_image.h"
#include "storage/catalogue/previews.h"

namespace skyquilt::server {

class PreviewCanvas {
 public:
  static constexpr int kTileSizePx = 256;

  PreviewCanvas(storage::PreviewTiles& stored, int min_zoom, int max_zoom)
      : stored_(stored), min_zoom_(min_zoom), max_zoom_(max_zoom) {}

  // Lays one encoded tile of a photo over what is there. Tiles of other zooms than the finest are passed
  // over: the overviews are of all photos.
  Result<void> Lay(const geo::TileId& tile, std::string_view bytes);
  Result<storage::PreviewTiles::Tiles> Finish();

 private:
  Result<image::RgbaImage> Load(const geo::TileId& tile);
  Result<void> DrawParents(int zoom);

  storage::PreviewTiles& stored_;
  const int min_zoom_;
  const int max_zoom_;
  std::map<geo::TileId, image::RgbaImage> changed_;
};

}  // namespace skyquilt::server
