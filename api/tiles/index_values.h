// IndexValues: what an expression comes to over a tile or any window of a map. The bands are those of
// bands.tif where the map has that, else red, green and blue of its tiles as 0..1. Any thread; decodes and
// computes, so where processor time is fine. Memory: up to 8 bytes per pixel and band. Errors:
// kInvalidArgument (a band that the map does not have; the message says which there are), kCorrupt, kIo, and
// those of fetching bands.tif.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/common/index_look.h"
#include "api/tiles/map_bands.h"
#include "api/tiles/map_window.h"
#include "core/geo/bounds.h"
#include "core/geo/tile_id.h"
#include "core/image/rgba_image.h"

namespace skyquilt::api {

struct IndexValues {
  int width_px = 0, height_px = 0;
  std::vector<float> values;         // rows from the north; NaN: no value
  std::vector<std::uint8_t> alphas;  // of the map; 0 where there is no value
};

// What is more transparent is the fringe of a map, and counts for no statistics.
inline constexpr std::uint8_t kSolidMapAlpha = 128;

// The bands of a map, in the order of its file.
Result<std::vector<std::string>> BandsOf(MapBands& map_bands, const storage::Tileset& tileset);
// Those that can be told without opening or fetching anything large: what lists of many maps say.
std::vector<std::string> BandsAtHand(MapBands& map_bands, const storage::Tileset& tileset);
Result<void> CheckBands(MapBands& map_bands, const storage::Tileset& tileset,
                        const indices::BandExpression& expression);

// Where indices may have values: in merc, of bands.tif, which may reach further than the map's tiles do.
// Absent: where these are.
Result<std::optional<geo::Bounds2>> BoundsOfBands(MapBands& map_bands, const storage::Tileset& tileset);

// Of a tile with so many pixels on a side. Where nothing is known there are no values.
Result<IndexValues> ValuesOfTile(MapBands& map_bands, const storage::Tileset& tileset,
                                 const indices::BandExpression& expression, const geo::TileId& tile,
                                 int side_px);
Result<IndexValues> ValuesOfWindow(MapBands& map_bands, const storage::Tileset& tileset,
                                   const indices::BandExpression& expression, const MapWindow& window);
// At the finest pixel there. Absent: no value.
Result<std::optional<double>> ValueAt(MapBands& map_bands, const storage::Tileset& tileset,
                                      const indices::BandExpression& expression, const Eigen::Vector2d& merc);

// Straight alpha; transparent where there is no value.
image::RgbaImage Coloured(const IndexValues& values, const IndexLook& look);

}  // namespace skyquilt::api
