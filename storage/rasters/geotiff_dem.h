// GeotiffDem: heights of the ground from a GeoTIFF elevation model in any coordinate system GDAL knows,
// between cells bilinearly, in metres (by the unit of the vertical axis or that stated of the band, whichever
// is no metre; else as they are), above the sea (the geoid taken off where the coordinate system counts
// heights from the ellipsoid). Reads blocks, never the whole file: at most 16 MiB large, with 64 MiB kept.
// One thread at a time. Errors of Open: kNotFound, kUnsupportedFormat (no GeoTIFF, one that does not say
// where it lies, or one in larger blocks).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/geo/dem_source.h"

namespace skyquilt::storage {

class GeotiffDem final : public geo::DemSource {
 public:
  static Result<std::unique_ptr<GeotiffDem>> Open(const std::filesystem::path& path);
  ~GeotiffDem() override;
  std::optional<double> GroundHeightM(const geo::LatLon& position) const override;
  // As the file has it; its heights count as metres. Empty: the unit is known, or none is stated.
  const std::string& unknown_unit() const;

 private:
  struct Raster;
  explicit GeotiffDem(std::unique_ptr<Raster> raster);
  std::unique_ptr<Raster> raster_;
};

}  // namespace skyquilt::storage
