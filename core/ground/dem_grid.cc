#include "core/ground/dem_grid.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace skyquilt::ground {
namespace {

constexpr double kMaxNodes = 250'000;

// From the nodes known, ring by ring, until none is left.
void FillHoles(std::vector<char>& known, MembraneGrid& grid) {
  const auto at = [&](int column, int row) { return static_cast<std::size_t>(row) * grid.columns + column; };
  while (std::find(known.begin(), known.end(), 0) != known.end()) {
    const std::vector<char> before = known;
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        if (before[at(column, row)]) continue;
        double sum = 0.0;
        int count = 0;
        for (int r = std::max(0, row - 1); r <= std::min(grid.rows - 1, row + 1); ++r) {
          for (int c = std::max(0, column - 1); c <= std::min(grid.columns - 1, column + 1); ++c) {
            if (!before[at(c, r)]) continue;
            sum += grid.heights_m[at(c, r)];
            ++count;
          }
        }
        if (count == 0) continue;
        grid.heights_m[at(column, row)] = static_cast<float>(sum / count);
        known[at(column, row)] = 1;
      }
    }
  }
}

}  // namespace

std::optional<MembraneGrid> SampleDem(const ElevationModel& model, const geo::LocalFrame& frame,
                                      const geo::Bounds2& area_in_enu, double cell_m) {
  MembraneGrid grid;
  grid.cell_m = std::max(cell_m, std::sqrt(area_in_enu.Width() * area_in_enu.Height() / kMaxNodes));
  grid.south_west_in_enu = area_in_enu.min;
  grid.columns = std::max(2, static_cast<int>(std::ceil(area_in_enu.Width() / grid.cell_m)) + 1);
  grid.rows = std::max(2, static_cast<int>(std::ceil(area_in_enu.Height() / grid.cell_m)) + 1);
  const std::size_t nodes = static_cast<std::size_t>(grid.columns) * grid.rows;
  grid.heights_m.assign(nodes, 0.0F);
  std::vector<char> known(nodes, 0);
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::size_t row = i / grid.columns, column = i % grid.columns;
    const Eigen::Vector2d at =
        grid.south_west_in_enu +
        grid.cell_m * Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row));
    const geo::Wgs84 place = frame.Wgs84FromEnu({at.x(), at.y(), 0.0});
    const auto height_m = model.source->GroundHeightM({place.lat_deg, place.lon_deg});
    if (!height_m) continue;
    const double ellipsoid_m = frame.origin().height_ellipsoid_m + *height_m - model.zero_m;
    grid.heights_m[i] =
        static_cast<float>(frame.EnuFromWgs84({place.lat_deg, place.lon_deg, ellipsoid_m}).z());
    known[i] = 1;
  }
  if (2 * static_cast<std::size_t>(std::count(known.begin(), known.end(), 1)) < nodes) return std::nullopt;
  FillHoles(known, grid);
  return grid;
}

}  // namespace skyquilt::ground
