// MapView: what every description of a map for other programs says: its name, bounds, zooms, tile size and
// where its tiles are. Any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/grids/map_grid.h"
#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

// The side of a pixel as OGC has it in scale denominators.
inline constexpr double kOgcPixelM = 0.00028;

// A tile matrix set that a map is to be had in: Web Mercator's with tiles of this side, or a grid that its
// tiles are resampled to.
struct MapSet {
  int side_px = 256;
  std::optional<MapGrid> grid = std::nullopt;

  std::string name() const;
};

struct MapView {
  std::string id;  // of the flight
  std::string name;
  std::shared_ptr<const storage::Tileset> tileset;
  std::string base_url;
  std::string token;  // "token=..." where the request came with one: links go on with it

  const storage::Revision& revision() const { return tileset->revision; }
  storage::ShownFlight shown() const { return {id, name, revision()}; }
  int tile_size_px() const;
  // Of the tiles to be had: 256 first, which every program knows, then that of the stored ones.
  std::vector<int> tile_sizes_px() const;
  // Web Mercator's first.
  std::vector<MapSet> sets() const;
  // kNotFound, with those that there are.
  Result<MapSet> SetNamed(std::string_view matrix_set) const;
  // base_url + path, with the token.
  std::string Link(std::string_view path) const;
};

// Errors: kNotFound (no such flight, or no map yet) and the catalogue's.
Result<MapView> FindMap(Service& service, const Request& request, const std::string& flight_id);

// One zoom of the square that all Web Mercator tilings share.
struct TileMatrix {
  int zoom = 0;
  double scale_denominator = 0.0;  // of kOgcPixelM
  double pixel_m = 0.0;            // in merc
  // The tiles that the map's bounds touch; across the antimeridian, where they are at both ends, all columns.
  std::uint32_t min_column = 0, max_column = 0, min_row = 0, max_row = 0;
};
std::vector<TileMatrix> MatricesOf(const MapView& map, int tile_size_px);  // one of the map's sizes
std::vector<TileMatrix> MatricesOf(const storage::Revision& revision, int stored_size_px, int tile_size_px);
// Of the tiles to be had of a map that has them stored in this size, as MapView::tile_sizes_px.
std::vector<int> TileSizesOf(int stored_size_px);
// "WebMercatorQuad", or with the side of its tiles where that is not 256.
std::string MatrixSetName(int tile_size_px);

}  // namespace skyquilt::api
