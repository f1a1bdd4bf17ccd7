// GeotiffPool: one GeoTIFF that this program made, read by many threads: each takes a dataset of its own, of
// which kMaxIdle are kept. The file is opened alone: nothing beside it says more of it. Any thread. Errors:
// kCorrupt (no GeoTIFF).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/result.h"

class GDALDataset;

namespace skyquilt::storage {

struct CloseDataset {
  void operator()(GDALDataset* dataset) const;
};
using OpenGeotiff = std::unique_ptr<GDALDataset, CloseDataset>;

class GeotiffPool {
 public:
  static constexpr std::size_t kMaxIdle = 2;

  explicit GeotiffPool(std::filesystem::path path) : path_(std::move(path)) {}

  Result<OpenGeotiff> Take();
  // One that read well, for the next.
  void Give(OpenGeotiff dataset);
  // Of what cannot be read in it, with GDAL's last words.
  Error Damaged(const std::string& what) const;

 private:
  const std::filesystem::path path_;
  std::mutex mutex_;
  std::vector<OpenGeotiff> idle_;
};

}  // namespace skyquilt::storage
