// MapGrid: a tile matrix set that is not Web Mercator's, as OGC registers it (OGC 17-083r4, Annex D, and its
// register at http://www.opengis.net/def/tilematrixset/OGC/1.0): WorldCRS84Quad, whose tiles are squares of
// degrees, and UTM01WGS84Quad to UTM60WGS84Quad, each of the whole Earth in the metres of one zone
// (EPSG:326nn, north and south of the equator alike). All tiles have 256 pixels; each level has half the
// cells of the one before. Coordinates are x (east, longitude) and y (north, latitude). A value; any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/tiles/map_crs.h"
#include "core/geo/bounds.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::api {

class MapGrid {
 public:
  static constexpr int kTilePx = 256;
  static constexpr int kZones = 60;

  static MapGrid WorldCrs84();
  // Precondition: 1 to 60.
  static MapGrid Utm(int zone);
  // Absent: no grid that is known here.
  static std::optional<MapGrid> Named(std::string_view name);

  std::string name() const;
  std::string title() const;
  std::string uri() const;        // of the grid itself
  std::string crs_urn() const;    // as WMTS has it
  const char* scale_set() const;  // "GoogleCRS84Quad"; empty where there is none
  bool is_in_degrees() const { return zone_ == 0; }
  Result<MapCrs> Crs() const;

  int first_level() const { return is_in_degrees() ? 0 : 1; }
  int last_level() const { return is_in_degrees() ? 23 : 24; }
  double CellSize(int level) const;  // degrees or metres of the zone
  double ScaleDenominator(int level) const;
  Eigen::Vector2d UpperLeft() const;
  std::int64_t Columns(int level) const;
  std::int64_t Rows(int level) const;
  geo::Bounds2 BoundsOf(int level, std::int64_t column, std::int64_t row) const;

 private:
  explicit MapGrid(int zone) : zone_(zone) {}
  int zone_;  // 0: degrees
};

// The grids that a map is to be had in beside Web Mercator: that of degrees, and that of the zone of its
// middle where UTM has one.
std::vector<MapGrid> GridsOf(const storage::Revision& revision);

// One level that a map is to be had in, and the tiles that its bounds touch (TileMatrix).
struct GridMatrix {
  int level = 0;
  std::int64_t min_column = 0, max_column = 0, min_row = 0, max_row = 0;
};
// From the coarsest zoom of the map to the first level that loses nothing of its finest one; where the grid
// ends before, to its last.
std::vector<GridMatrix> MatricesOf(const MapGrid& grid, const storage::Revision& revision,
                                   int stored_size_px);

}  // namespace skyquilt::api
