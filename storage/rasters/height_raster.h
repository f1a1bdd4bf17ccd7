// HeightRaster: the heights of a map, dsm.tif or dtm.tif beside its tiles, with which of them were measured
// (dsm_photos.tif, dtm_ground.tif): files that SurfaceWriter made, on the same cells of a UTM zone. Heights
// in metres, float32, NaN where nothing is known. Between cells bilinearly, of what is known there; where the
// nearest cell is unknown, so is the place. Coarser grids come from the overviews.
//
// Any thread. Memory: GDAL's block cache and what is read. Errors: kCorrupt (no such files of ours),
// kInvalidArgument (a grid beyond kMaxSidePx).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/geo/boundary.h"
#include "core/geo/bounds.h"
#include "core/geo/crs/map_projection.h"
#include "core/geo/lat_lon.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/surface/terrain/volume.h"
#include "storage/rasters/geotiff_pool.h"
#include "storage/rasters/merc_grid.h"

namespace skyquilt::storage {

class PlacesInZone;

// The cells within an area, rows from the north.
struct HeightCells {
  int columns = 0, rows = 0;
  double cell_m = 1.0;  // on the ground; more than the file's where the area has too many
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_measured, is_inside;
  std::vector<surface::EdgeHeight>
      edge;  // along the rings, a cell apart if they are not too long; of known ones
  // Where they lie: the corner in the north-west and the sides of a cell, in a zone.
  int epsg = 0;
  Eigen::Vector2d corner_in_zone_m = Eigen::Vector2d::Zero(), sides_in_zone_m = Eigen::Vector2d::Ones();
};

// Of other cells than the raster's own; NaN where it knows none.
struct SampledHeights {
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_measured;
};

class HeightRaster {
 public:
  static constexpr int kMaxSidePx = 4096;
  static constexpr double kMaxCells = 8 << 20;       // of an area: averages of more
  static constexpr double kMaxEdgePlaces = 200'000;  // along its rings

  static Result<std::shared_ptr<HeightRaster>> Open(const std::filesystem::path& heights,
                                                    const std::filesystem::path& measured);

  double cell_m() const { return cell_m_; }  // of the zone

  Result<std::vector<std::optional<double>>> HeightsAt(std::span<const geo::LatLon> places);
  // With a height everywhere: beyond what is known it goes on from there, coarsely.
  Result<std::vector<float>> GoingOnOver(const MercGrid& grid);
  // Absent: the area and the raster have no cell in common.
  Result<std::optional<HeightCells>> Within(const geo::Boundary& area);
  Result<SampledHeights> Over(const MercGrid& grid);
  // At the middles of another raster's cells, where this one lies moved by so much.
  Result<SampledHeights> On(const HeightCells& cells, const Eigen::Vector2d& moved_by_merc_m);

 private:
  // The whole raster on few cells, without holes.
  struct Sketch {
    int columns = 0, rows = 0;
    std::vector<float> heights_m;
  };
  HeightRaster(const std::filesystem::path& heights, const std::filesystem::path& measured)
      : heights_(heights), measured_(measured) {}
  // Counted in cells from the north-west corner.
  Eigen::Vector2d CellOf(const Eigen::Vector2d& in_zone) const {
    return {(in_zone.x() - west_m_) / cell_m_, (north_m_ - in_zone.y()) / cell_m_};
  }
  struct RingsInCells {
    std::vector<std::vector<geo::RingEdge>> polygons;
    geo::Bounds2 bounds;
    double length = 0.0;  // of all edges
  };
  // Of what of it lies about the raster.
  RingsInCells RingsOf(const geo::Boundary& area, const geo::MapProjection& zone) const;
  // The side of a cell about a place, on the ground.
  double GroundCellM(const Eigen::Vector2d& cell, const geo::MapProjection& zone) const;
  bool FindAround(const geo::MapProjection& zone);
  // `places` in this raster's zone, at the level of detail that they are apart.
  Result<SampledHeights> Sample(const PlacesInZone& places);
  Result<Sketch> MakeSketch(GDALDataset& file) const;

  GeotiffPool heights_, measured_;
  int epsg_ = 0;
  double west_m_ = 0.0, north_m_ = 0.0, cell_m_ = 1.0;  // of the zone
  int columns_ = 0, rows_ = 0;
  geo::LatLonBounds around_;  // an eighth of it beyond its sides, and on beyond the antimeridian
  Sketch sketch_;
};

}  // namespace skyquilt::storage
