// TilesetCache: the tileset that a flight shows now, opened once and kept while it is used. What a request
// gets it may hold to its end: a newer revision never changes an older one. Another process publishes, so the
// catalogue is read again after kFreshFor, and every time for a flight without a map. Any thread.
// Errors: kNotFound (no such flight, or it has no map yet), kCorrupt, kUnavailable, kIo.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "core/base/result.h"
#include "core/render/map_layer.h"
#include "storage/catalogue/catalogue.h"
#include "storage/folder/data_dir.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {

// One revision of one flight, ready to be read.
struct Tileset {
  std::string flight_id;
  Revision revision;
  std::shared_ptr<MbtilesReader> reader;
  std::map<render::MapLayer, std::shared_ptr<MbtilesReader>> layers;  // those that the map has
};

class TilesetCache {
 public:
  static constexpr std::chrono::milliseconds kFreshFor{100};
  static constexpr std::size_t kMaxOpen = 256;

  TilesetCache(DataDir dir, Catalogue& catalogue) : dir_(std::move(dir)), catalogue_(catalogue) {}
  Result<std::shared_ptr<const Tileset>> Get(const std::string& flight_id);
  // True: Get opens no file, unless a newer revision was published a moment ago.
  bool IsOpen(const std::string& flight_id) const;
  // The flight was deleted here: gone for the next request.
  void Forget(const std::string& flight_id);

 private:
  struct Entry {
    std::shared_ptr<const Tileset> tileset;
    std::chrono::steady_clock::time_point checked;
    std::chrono::steady_clock::time_point used;
  };
  Result<std::shared_ptr<const Tileset>> Refresh(const std::string& flight_id);
  void DropLeastUsed();

  DataDir dir_;
  Catalogue& catalogue_;
  mutable std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
};

}  // namespace skyquilt::storage
