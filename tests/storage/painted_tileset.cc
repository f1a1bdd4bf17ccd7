#include "tests/storage/painted_tileset.h"

#include <cmath>
#include <map>
#include <stdexcept>

#include "core/geo/hilbert.h"
#include "core/pyramid/build_overviews.h"
#include "core/pyramid/encode_tile.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::test {
namespace {

void Require(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error().message);
}

}  // namespace

image::RgbaImage PaintedTile(const PaintedTileset& tileset, int column, int row) {
  const int side = tileset.tile_size_px;
  auto image = image::RgbaImage::Transparent(side, side);
  const double middle_x = 0.5 * tileset.columns * side, middle_y = 0.5 * tileset.rows * side;
  const double radius = 0.48 * std::min(tileset.columns, tileset.rows) * side;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double map_x = column * side + x, map_y = row * side + y;
      if (std::hypot(map_x - middle_x, map_y - middle_y) > radius) continue;
      std::uint8_t* pixel = image.Pixel(x, y);
      pixel[0] = static_cast<std::uint8_t>(128 + 100 * std::sin(map_x / 40.0));
      pixel[1] = static_cast<std::uint8_t>(128 + 100 * std::sin(map_y / 30.0));
      pixel[2] = static_cast<std::uint8_t>(128 + 60 * std::sin((map_x + map_y) / 50.0));
      pixel[3] = 255;
    }
  }
  return image;
}

void WritePaintedTileset(const std::filesystem::path& path, const PaintedTileset& tileset) {
  auto created = storage::MbtilesWriter::Create(path);
  if (!created) throw std::runtime_error(created.error().message);
  storage::MbtilesWriter& writer = **created;
  pyramid::EncodeOptions options;
  options.encoding = tileset.encoding;
  options.quality = tileset.quality;
  const auto put = [&](const geo::TileId& tile, const image::RgbaImage& image) {
    if (const auto encoded = pyramid::EncodeTile(image, options))
      Require(writer.Put(tile, encoded->format, encoded->bytes));
  };
  int levels = 0;
  while ((tileset.first_column >> levels) != ((tileset.first_column + tileset.columns - 1) >> levels) ||
         (tileset.first_row >> levels) != ((tileset.first_row + tileset.rows - 1) >> levels)) {
    ++levels;
  }
  const int min_zoom = tileset.zoom - levels;
  pyramid::OverviewBuilder overviews(tileset.zoom, min_zoom, tileset.tile_size_px, put);
  std::map<std::uint64_t, geo::TileId> ordered;
  for (int row = 0; row < tileset.rows; ++row) {
    for (int column = 0; column < tileset.columns; ++column) {
      const auto tile =
          geo::TileId::Make(tileset.zoom, tileset.first_column + column, tileset.first_row + row);
      ordered[geo::HilbertIndex(tileset.zoom, tile->x(), tile->y())] = *tile;
    }
  }
  for (const auto& [index, tile] : ordered) {
    const auto image = PaintedTile(tileset, static_cast<int>(tile.x()) - tileset.first_column,
                                   static_cast<int>(tile.y()) - tileset.first_row);
    put(tile, image);
    overviews.Add(tile, image);
  }
  overviews.Finish();
  storage::TilesetMetadata metadata;
  metadata.name = "painted \"map\"";
  metadata.bounds = {-10.0, 20.0, -9.0, 21.0};
  metadata.min_zoom = min_zoom;
  metadata.max_zoom = tileset.zoom;
  metadata.tile_size_px = tileset.tile_size_px;
  Require(writer.Publish(metadata));
}

}  // namespace skyquilt::test
