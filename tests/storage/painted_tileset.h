// A small tileset with real tiles: opaque JPEG inside, WebP or PNG with alpha at the fringe, overviews to one
// tile.
#pragma once

#include <filesystem>

#include "core/image/rgba_image.h"
#include "core/pyramid/encode_tile.h"

namespace skyquilt::test {

struct PaintedTileset {
  int zoom = 18;
  int tile_size_px = 256;
  int first_column = 0, first_row = 0;  // from the north
  int columns = 0, rows = 0;
  image::TileEncoding encoding = image::TileEncoding::kJpegWebp;
  int quality = 85;
};

// Colours vary smoothly over the map; a disk of it is covered, the rest is transparent and has no tiles.
image::RgbaImage PaintedTile(const PaintedTileset& tileset, int column, int row);
void WritePaintedTileset(const std::filesystem::path& path, const PaintedTileset& tileset);

}  // namespace skyquilt::test
