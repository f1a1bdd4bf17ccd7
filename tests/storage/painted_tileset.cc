#include "tests/storage/painted_tileset.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "core/geo/tile_id.h"
#include "core/pyramid/build_overviews.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::test {
namespace {

void Require(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error().message);
}

// `count` levels along a wave, from pixel `first` on.
std::vector<std::uint8_t> Wave(int first, int count, double height, double length) {
  std::vector<std::uint8_t> levels;
  for (int i = first; i < first + count; ++i)
    levels.push_back(static_cast<std::uint8_t>(128 + height * std::sin(i / length)));
  return levels;
}

}  // namespace

image::RgbaImage PaintedTile(const PaintedTileset& tileset, int column, int row) {
  const int side = tileset.tile_size_px;
  auto image = image::RgbaImage::Transparent(side, side);
  const double middle_x = 0.5 * tileset.columns * side, middle_y = 0.5 * tileset.rows * side;
  const double radius = 0.48 * std::min(tileset.columns, tileset.rows) * side;
  const int left = column * side, top = row * side;
  const std::vector<std::uint8_t> red = Wave(left, side, 100, 40.0), green = Wave(top, side, 100, 30.0),
                                  blue = Wave(left + top, 2 * side, 60, 50.0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double from_middle_x = left + x - middle_x, from_middle_y = top + y - middle_y;
      if (from_middle_x * from_middle_x + from_middle_y * from_middle_y > radius * radius) continue;
      std::uint8_t* pixel = image.Pixel(x, y);
      pixel[0] = red[static_cast<std::size_t>(x)];
      pixel[1] = green[static_cast<std::size_t>(y)];
      pixel[2] = blue[static_cast<std::size_t>(x + y)];
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
