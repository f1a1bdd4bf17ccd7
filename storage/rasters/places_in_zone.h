// PlacesInZone: where the pixels of a grid lie in a zone's metres: at every kPxBetweenNodes-th pixel by
// projection, straight between, which so far apart is as good. A value; any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/geo/crs/map_projection.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/merc_grid.h"

namespace skyquilt::storage {

class PlacesInZone {
 public:
  // `place_at` gives the place of a corner between pixels, counted from the first, or none. Absent: some of
  // the grid lies where the zone says nothing.
  template <typename PlaceAt>
  static std::optional<PlacesInZone> Of(int columns, int rows, const PlaceAt& place_at,
                                        const geo::MapProjection& zone) {
    PlacesInZone places;
    places.columns_ = columns;
    places.rows_ = rows;
    places.across_ = SpanOfNodes(columns) / kPxBetweenNodes + 1;
    const int down = SpanOfNodes(rows) / kPxBetweenNodes + 1;
    for (int row = 0; row < down; ++row) {
      for (int column = 0; column < places.across_; ++column) {
        const std::optional<geo::LatLon> at = place_at(column * kPxBetweenNodes, row * kPxBetweenNodes);
        const std::optional<Eigen::Vector2d> place = at ? zone.PlaceOf(*at) : std::nullopt;
        if (!place) return std::nullopt;
        places.nodes_.push_back(*place);
      }
    }
    return places;
  }
  static std::optional<PlacesInZone> Of(const MercGrid& grid, const geo::MapProjection& zone) {
    return Of(
        grid.width_px, grid.height_px,
        [&](int column, int row) {
          return std::optional(geo::LatLonFromMerc(
              {grid.west_m + column * grid.pixel_width_m, grid.north_m - row * grid.pixel_height_m}));
        },
        zone);
  }

  // Of a pixel's middle.
  Eigen::Vector2d At(int column, int row) const {
    const double x = (column + 0.5) / kPxBetweenNodes, y = (row + 0.5) / kPxBetweenNodes;
    const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
    const double u = x - static_cast<double>(left), v = y - static_cast<double>(top);
    const Eigen::Vector2d* node = nodes_.data() + top * static_cast<std::size_t>(across_) + left;
    return (1 - v) * ((1 - u) * node[0] + u * node[1]) +
           v * ((1 - u) * node[across_] + u * node[across_ + 1]);
  }
  // From the first node to the last along so many pixels.
  static int SpanOfNodes(int pixels) {
    return (pixels + kPxBetweenNodes - 1) / kPxBetweenNodes * kPxBetweenNodes;
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const std::vector<Eigen::Vector2d>& nodes() const { return nodes_; }

 private:
  static constexpr int kPxBetweenNodes = 16;

  int columns_ = 0, rows_ = 0, across_ = 0;
  std::vector<Eigen::Vector2d> nodes_;
};

}  // namespace skyquilt::storage
