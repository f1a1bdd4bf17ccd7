// PmtilesReader: tiles out of one finished PMTiles archive, wherever it lies, by ranges: header, root and
// metadata are read once; a tile takes one read, and another where its leaf directory is not in memory; tiles
// that were asked for lately are in memory. Any number of threads. Errors: kNotFound, kCorrupt,
// kUnsupportedFormat and those of the store; kUnavailable too where what a store gave is damaged.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/blobs/lru_memory.h"
#include "storage/pmtiles/pmtiles_archive.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// What all maps that are open share of memory. Any thread.
struct PmtilesMemory {
  static constexpr std::size_t kUsualLeafBytes = std::size_t{64} << 20;
  static constexpr std::size_t kUsualTileBytes = std::size_t{64} << 20;

  explicit PmtilesMemory(std::size_t leaf_bytes = kUsualLeafBytes, std::size_t tile_bytes = kUsualTileBytes)
      : leaves(leaf_bytes), tiles(tile_bytes) {}

  LruMemory<std::vector<PmtilesEntry>> leaves;  // unpacked
  LruMemory<FoundTile> tiles;                   // with their bytes
};

class PmtilesReader final : public MapTiles {
 public:
  static Result<std::shared_ptr<PmtilesReader>> Open(std::shared_ptr<BlobStore> blobs, const std::string& key,
                                                     std::shared_ptr<PmtilesMemory> memory);

  Result<std::optional<FoundTile>> Find(const geo::TileId& tile) override;
  bool IsAtHand(const geo::TileId& tile) const override;
  const std::map<std::string, std::string>& metadata() const override { return metadata_; }

 private:
  PmtilesReader(std::shared_ptr<BlobStore> blobs, std::string key, std::shared_ptr<PmtilesMemory> memory)
      : blobs_(std::move(blobs)), key_(std::move(key)), memory_(std::move(memory)) {}
  Result<std::string> Read(const PmtilesSection& section, std::uint64_t offset, std::uint64_t length) const;
  // What is wrong in what a store gave is doubted before the map is.
  Error Doubted(const Error& error) const;
  using Directory = std::shared_ptr<const std::vector<PmtilesEntry>>;
  Result<Directory> Leaf(const PmtilesEntry& entry) const;
  // In memory: names of what lies there in the archive.
  std::string NameOf(char kind, std::uint64_t place) const { return key_ + kind + std::to_string(place); }

  const std::shared_ptr<BlobStore> blobs_;
  const std::string key_;
  const std::shared_ptr<PmtilesMemory> memory_;
  PmtilesHeader header_;
  std::vector<PmtilesEntry> root_;
  std::map<std::string, std::string> metadata_;
};

}  // namespace skyquilt::storage
