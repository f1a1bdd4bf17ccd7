#include "storage/rasters/geotiff_pool.h"

#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <array>
#include <utility>

#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {

void CloseDataset::operator()(GDALDataset* dataset) const { GDALClose(dataset); }

Result<OpenGeotiff> GeotiffPool::Take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      OpenGeotiff dataset = std::move(idle_.back());
      idle_.pop_back();
      return dataset;
    }
  }
  RegisterGdalOnce();
  constexpr std::array<const char*, 2> kDrivers = {"GTiff", nullptr};
  const std::string name = path_.filename();
  const std::array<const char*, 2> beside = {name.c_str(), nullptr};
  OpenGeotiff dataset(GDALDataset::Open(path_.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data(),
                                        nullptr, beside.data()));
  if (!dataset) return Damaged("it is no GeoTIFF");
  return dataset;
}

void GeotiffPool::Give(OpenGeotiff dataset) {
  const std::lock_guard lock(mutex_);
  if (idle_.size() < kMaxIdle) idle_.push_back(std::move(dataset));
}

Error GeotiffPool::Damaged(const std::string& what) const {
  return {ErrorCode::kCorrupt,
          fmt::format("The map's file {} cannot be read: {}. Start its job again.", path_.filename().string(),
                      what),
          path_.string() + ": " + CPLGetLastErrorMsg()};
}

}  // namespace skyquilt::storage
