// PreviewCache: the preview that a flight shows now, opened once and kept while it is used. Another
// process draws it, so the catalogue is read again after kFreshFor. Any thread. Errors: kNotFound (the
// flight has no preview), kUnavailable, kIo.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "storage/catalogue/previews.h"
#include "storage/files/data_dir.h"
#include "storage/tilesets/preview_tiles.h"

namespace skyquilt::storage {

struct OpenPreview {
  Preview preview;
  std::shared_ptr<PreviewTiles> tiles;
};

class PreviewCache {
 public:
  static constexpr std::chrono::milliseconds kFreshFor{100};
  static constexpr std::size_t kMaxOpen = 64;

  PreviewCache(DataDir dir, const Previews& previews) : dir_(std::move(dir)), previews_(previews) {}
  Result<std::shared_ptr<const OpenPreview>> Get(const std::string& flight_id);

 private:
  struct Entry {
    std::shared_ptr<const OpenPreview> open;
    std::chrono::steady_clock::time_point checked;
  };
  DataDir dir_;
  const Previews& previews_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace skyquilt::storage
