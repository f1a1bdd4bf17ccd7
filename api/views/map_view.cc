#include "api/views/map_view.h"

#include <fmt/format.h>

#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
int MapView::tile_size_px() const { return TileSizePx(*tileset); }

std::vector<int> MapView::tile_sizes_px() const { return TileSizesOf(tile_size_px()); }

std::vector<int> TileSizesOf(int stored_size_px) {
  if (stored_size_px == kUsualTilePx || !CutDepth(kUsualTilePx, stored_size_px)) return {stored_size_px};
  return {kUsualTilePx, stored_size_px};
}

std::string MapSet::name() const { return grid ? grid->name() : MatrixSetName(side_px); }

std::vector<MapSet> MapView::sets() const {
  std::vector<MapSet> sets;
  for (const int side_px : tile_sizes_px()) sets.push_back({side_px});
  for (const MapGrid& grid : GridsOf(revision())) sets.push_back({MapGrid::kTilePx, grid});
  return sets;
}

Result<MapSet> MapView::SetNamed(std::string_view matrix_set) const {
  std::string names;
  for (const MapSet& set : sets()) {
    const std::string known = set.name();
    if (known == matrix_set) return set;
    names += (names.empty() ? "" : ", ") + known;
  }
  return Error{ErrorCode::kNotFound, "The tile matrix sets of this map: " + names + "."};
}

std::string MapView::Link(std::string_view path) const { return WithToken(base_url, path, token); }

Result<MapView> FindMap(Service& service, const Request& request, const std::string& flight_id) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  return MapView{flight_id, flight.name, tileset, request.base_url, TokenInQuery(request)};
}

std::string MatrixSetName(int tile_size_px) {
  return tile_size_px == kUsualTilePx ? "WebMercatorQuad" : fmt::format("WebMercatorQuad{}", tile_size_px);
}

std::vector<TileMatrix> MatricesOf(const MapView& map, int tile_size_px) {
  return MatricesOf(map.revision(), map.tile_size_px(), tile_size_px);
}

std::vector<TileMatrix> MatricesOf(const storage::Revision& revision, int stored_size_px, int tile_size_px) {
  const geo::LatLonBounds& bounds = revision.bounds;
  const Eigen::Vector2d north_west = geo::MercFromLatLon(bounds.NorthWest());
  const Eigen::Vector2d south_east = geo::MercFromLatLon(bounds.SouthEast());
  std::vector<TileMatrix> matrices;
  const int depth = CutDepth(tile_size_px, stored_size_px).value_or(0);
  for (int zoom = revision.min_zoom + depth; zoom <= revision.max_zoom + depth; ++zoom) {
    TileMatrix matrix;
    matrix.zoom = zoom;
    matrix.pixel_m = geo::PixelSizeInMercM(zoom, tile_size_px);
    matrix.scale_denominator = matrix.pixel_m / kOgcPixelM;
    const geo::TileId first = geo::TileId::AtMerc(zoom, north_west);
    const geo::TileId last = geo::TileId::AtMerc(zoom, south_east);
    const bool is_across = bounds.east_deg > 180.0;
    matrix.min_column = is_across ? 0U : first.x();
    matrix.max_column = is_across ? (std::uint32_t{1} << zoom) - 1 : last.x();
    matrix.min_row = first.y();
    matrix.max_row = last.y();
    matrices.push_back(matrix);
  }
  return matrices;
}

}  // namespace skyquilt::api
