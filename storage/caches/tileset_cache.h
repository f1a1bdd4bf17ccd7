// TilesetCache: the tileset that a flight shows now, opened once and kept while it is used. What a request
// gets it may hold to its end: a newer revision never changes an older one. Another process publishes, so the
// catalogue is read again after kFreshFor, and every time for a flight without a map. While a catalogue that
// many machines share does not answer, or a newer map comes slowly out of its store, what is open stays
// shown. A map in the data folder is read from its MBTiles, one that lies elsewhere from its PMTiles by
// ranges. Any thread. Errors: kNotFound (no such flight, or it has no map yet), kCorrupt, kUnavailable, kIo.
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
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/db/outage/read_again.h"
#include "storage/files/data_dir.h"
#include "storage/pmtiles/pmtiles_reader.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// One revision of one flight, ready to be read.
struct Tileset {
  std::string flight_id;
  Revision revision;
  std::shared_ptr<MapTiles> reader;
  std::map<render::MapLayer, std::shared_ptr<MapTiles>> layers;  // those that the map has
};

class TilesetCache {
 public:
  static constexpr std::chrono::milliseconds kFreshFor{100};
  static constexpr std::size_t kMaxOpen = 256;

  // `blobs`: where maps lie; absent: in the data folder.
  // `is_shared`: the catalogue is a database that may be away.
  TilesetCache(DataDir dir, Catalogue& catalogue, std::shared_ptr<BlobStore> blobs = nullptr,
               bool is_shared = false);
  Result<std::shared_ptr<const Tileset>> Get(const std::string& flight_id);
  // The same for threads that must not wait for a store or another machine's database: null where Get may,
  // or has none. In a data folder with its own catalogue a newer revision is opened here.
  std::shared_ptr<const Tileset> AtHand(const std::string& flight_id);
  // Whether the catalogue can be read, known within seconds also where it does not answer.
  Result<void> CheckCatalogue() const;
  // The flight was deleted here: gone for the next request.
  void Forget(const std::string& flight_id);

 private:
  struct Entry {
    std::shared_ptr<const Tileset> tileset;
    std::chrono::steady_clock::time_point checked;
    std::chrono::steady_clock::time_point used;
    std::int64_t newest = 0;     // revision that the catalogue is known to show
    std::weak_ptr<int> opening;  // held by who opens it
  };
  // What the catalogue shows now.
  Result<Revision> Look(const std::string& flight_id);
  ReadAgain::Read Looking(const std::string& flight_id);
  Result<std::shared_ptr<const Tileset>> Refresh(const std::string& flight_id);
  void DropLeastUsed();

  DataDir dir_;
  Catalogue& catalogue_;
  const std::shared_ptr<BlobStore> blobs_;
  const std::shared_ptr<PmtilesMemory> memory_ = std::make_shared<PmtilesMemory>();
  mutable std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
  const bool is_shared_;
  ReadAgain again_;  // with the next, last: their threads use all of the above
  mutable ReadAgain looks_;
};

}  // namespace skyquilt::storage
