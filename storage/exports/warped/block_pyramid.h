// Blocks over a grid: their levels, the order in which they can be made so that few are held (by units of
// some blocks each, which are made on any thread, and the overviews above them, of which one row of four
// waits at each level), and the file that has them until the places of all are known. One thread. Errors of
// the file: kIo, kOutOfSpace.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/image/rgba_image.h"
#include "storage/exports/stored_tiles.h"

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

// Blocks that are kept in a file until it is known where they belong. The file has no name any more while it
// is used, so that it goes however the program ends.
class BlockSpool {
 public:
  static Result<std::unique_ptr<BlockSpool>> Create(const std::filesystem::path& path);
  ~BlockSpool();
  BlockSpool(const BlockSpool&) = delete;
  BlockSpool& operator=(const BlockSpool&) = delete;

  std::uint64_t length() const { return length_; }
  // Behind what is there: at length() as it was.
  Result<void> Append(std::string_view block);
  // After the last one, before the first is read.
  Result<void> Flush();
  Result<std::string> Read(std::uint64_t offset, std::uint64_t bytes);

 private:
  BlockSpool(std::filesystem::path path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  const std::filesystem::path path_;
  std::FILE* file_;
  std::uint64_t length_ = 0;
};

}  // namespace skyquilt::storage
