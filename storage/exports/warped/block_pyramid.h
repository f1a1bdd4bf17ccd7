// Blocks over a grid: their levels, and the order in which they can be made so that few are
// held: by units of some blocks each, which are made on any thread, and the overviews above them, of which
// one row of four waits at each level. A value; one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/image/rgba_image.h"
#include "storage/exports/tile_grid.h"

namespace skyquilt::storage {

struct BlockId {
  std::size_t level = 0;
  std::int64_t column = 0, row = 0;

  BlockId Child(int i) const { return {level - 1, 2 * column + i % 2, 2 * row + i / 2}; }
};

// The finest first, until one block holds all.
std::vector<GridLevel> LevelsOver(std::int64_t width_px, std::int64_t height_px);

bool IsWithin(const std::vector<GridLevel>& levels, const BlockId& block);

// The blocks of a level, so that four of one parent follow each other.
std::vector<BlockId> InQuarters(const std::vector<GridLevel>& levels, std::size_t level);

// What is made of four blocks as soon as all of them are there.
class Overviews {
 public:
  // `made`: takes a finished block; nothing where it shows nothing.
  using Taker = std::function<Result<void>(const BlockId&, const std::optional<image::RgbaImage>&)>;
  Overviews(const std::vector<GridLevel>& levels, Taker made) : levels_(levels), made_(std::move(made)) {}

  // A block of the level that InQuarters ordered, in that order.
  Result<void> Add(const BlockId& block, std::optional<image::RgbaImage> pixels);

 private:
  struct Waiting {
    int missing = 0;
    std::vector<std::optional<image::RgbaImage>> children;
  };
  const std::vector<GridLevel>& levels_;
  const Taker made_;
  std::map<std::pair<std::size_t, std::pair<std::int64_t, std::int64_t>>, Waiting> waiting_;
};

// The block above four; nothing where none of them shows anything.
std::optional<image::RgbaImage> Above(const std::vector<std::optional<image::RgbaImage>>& children);

}  // namespace skyquilt::storage
