// MbtilesReader: tiles out of one finished MBTiles file, which never changes again (opened immutable).
// Any file with `tiles` is read; one with integer-keyed `tiles_shallow` + `tiles_data` answers
// "which bytes" without touching the bytes, so that a 304 reads no blob page. Any number of threads; each
// takes a connection of a pool for the time of a call. The file may be unlinked while it is open. Errors:
// kNotFound, kCorrupt, kIo. https://github.com/mapbox/mbtiles-spec/blob/master/1.3/spec.md
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

class MbtilesReader final : public MapTiles {
 public:
  static Result<std::shared_ptr<MbtilesReader>> Open(const std::filesystem::path& path);
  ~MbtilesReader() override;

  Result<std::optional<FoundTile>> Find(const geo::TileId& tile) override;
  Result<std::string> Load(FoundTile tile) override;

  const std::map<std::string, std::string>& metadata() const override { return metadata_; }

 private:
  struct Connection;
  struct Returner;
  using Borrowed = std::unique_ptr<Connection, Returner>;
  explicit MbtilesReader(std::filesystem::path path);
  Result<std::unique_ptr<Connection>> Connect() const;
  Result<Borrowed> Borrow();

  std::filesystem::path path_;
  bool is_deduplicated_ = false;
  std::map<std::string, std::string> metadata_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace skyquilt::storage
