// MadeTiles: tiles in another format or size than the one they are stored in, kept in memory within a budget
// of bytes; those not asked for longest go first. Each is made once, also when many ask for it at the same
// time: the others wait for the one who makes it. A key names the revision, so that a newer map has other
// keys. Any thread. Errors: those of making it, which all who wait are told.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "storage/blobs/lru_memory.h"

namespace skyquilt::storage {

struct MadeTileKey {
  std::string flight_id;
  std::int64_t revision = 0;
  geo::TileId tile;
  image::PictureFormat format = image::PictureFormat::kPng;
  int scale = 1;
  int cut_px = 0;         // side of a tile that was cut from a larger one; 0: it was not
  int whole_px = 0;       // longer side of a small picture of the whole map, no tile; 0: a tile
  std::string look = {};  // of an index: which, and how it is coloured; empty: the map's own colours
  std::string grid = {};  // a tile of another grid: which, level, row and column; empty: of Web Mercator

  std::string Text() const;
};

struct MadeTile {
  std::string bytes;
  std::uint64_t digest = 0;  // of the bytes; for an ETag
};

class MadeTiles {
 public:
  static constexpr std::size_t kUsualBudgetBytes = std::size_t{64} << 20;

  explicit MadeTiles(std::size_t budget_bytes = kUsualBudgetBytes) : tiles_(budget_bytes) {}
  // Before the first use.
  void SetBudget(std::size_t bytes) { tiles_.SetBudget(bytes); }

  // Null: nobody has made it yet, or it has gone.
  std::shared_ptr<const MadeTile> Find(const MadeTileKey& key) { return tiles_.Find(key.Text()); }
  Result<std::shared_ptr<const MadeTile>> Get(const MadeTileKey& key,
                                              const std::function<Result<std::string>()>& make);

  struct Kept {
    std::size_t tiles = 0;
    std::size_t bytes = 0;
  };
  Kept kept() const { return {tiles_.count(), tiles_.bytes()}; }

 private:
  struct Making {
    bool is_done = false;
    Result<std::shared_ptr<const MadeTile>> outcome{std::shared_ptr<const MadeTile>()};
  };
  class Maker;

  LruMemory<MadeTile> tiles_;
  std::mutex mutex_;  // of what is being made
  std::condition_variable made_;
  std::unordered_map<std::string, std::shared_ptr<Making>> making_;
};

}  // namespace skyquilt::storage
