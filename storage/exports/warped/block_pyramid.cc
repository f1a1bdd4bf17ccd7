#include "storage/exports/warped/block_pyramid.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "core/base/try.h"
#include "storage/exports/warped/resample_block.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {

std::vector<GridLevel> LevelsOver(std::int64_t width_px, std::int64_t height_px) {
  std::vector<GridLevel> levels;
  while (true) {
    GridLevel level;
    level.width_px = width_px;
    level.height_px = height_px;
    level.columns = (width_px + kWarpedBlockPx - 1) / kWarpedBlockPx;
    level.rows = (height_px + kWarpedBlockPx - 1) / kWarpedBlockPx;
    levels.push_back(level);
    if (level.columns <= 1 && level.rows <= 1) return levels;
    width_px = (width_px + 1) / 2;
    height_px = (height_px + 1) / 2;
  }
}

bool IsWithin(const std::vector<GridLevel>& levels, const BlockId& block) {
  return block.column < levels[block.level].columns && block.row < levels[block.level].rows;
}

std::vector<BlockId> InQuarters(const std::vector<GridLevel>& levels, std::size_t level) {
  std::vector<BlockId> blocks = {{levels.size() - 1, 0, 0}};
  for (std::size_t at = levels.size() - 1; at > level; --at) {
    std::vector<BlockId> finer;
    for (const BlockId& block : blocks) {
      for (int i = 0; i < 4; ++i) {
        if (IsWithin(levels, block.Child(i))) finer.push_back(block.Child(i));
      }
    }
    blocks = std::move(finer);
  }
  return blocks;
}

std::optional<image::RgbaImage> Above(const std::vector<std::optional<image::RgbaImage>>& children) {
  std::array<const image::RgbaImage*, 4> quarters{};
  for (std::size_t i = 0; i < quarters.size(); ++i) quarters[i] = children[i] ? &*children[i] : nullptr;
  if (std::all_of(quarters.begin(), quarters.end(), [](const auto* one) { return one == nullptr; }))
    return std::nullopt;
  return HalveBlocks(quarters);
}

Result<void> Overviews::Add(const BlockId& block, std::optional<image::RgbaImage> pixels) {
  if (block.level + 1 == levels_.size()) return {};
  const BlockId parent{block.level + 1, block.column / 2, block.row / 2};
  const auto key = std::pair{parent.level, std::pair{parent.row, parent.column}};
  auto [found, is_first] = waiting_.try_emplace(key);
  Waiting& waiting = found->second;
  if (is_first) {
    waiting.children.resize(4);
    for (int i = 0; i < 4; ++i) waiting.missing += IsWithin(levels_, parent.Child(i)) ? 1 : 0;
  }
  waiting.children[static_cast<std::size_t>(block.row % 2 * 2 + block.column % 2)] = std::move(pixels);
  if (--waiting.missing > 0) return {};
  std::optional<image::RgbaImage> made = Above(waiting.children);
  waiting_.erase(found);
  SKYQUILT_TRY(made_(parent, made));
  return Add(parent, std::move(made));
}

Result<std::unique_ptr<BlockSpool>> BlockSpool::Create(const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "w+be");
  if (file == nullptr) return FileError("cannot write", path, errno);
  std::error_code gone;  // else it lies there until somebody removes it
  std::filesystem::remove(path, gone);
  return std::unique_ptr<BlockSpool>(new BlockSpool(path, file));
}

BlockSpool::~BlockSpool() { std::fclose(file_); }  // whatever was to be read has been

Result<void> BlockSpool::Append(std::string_view block) {
  if (fseeko(file_, static_cast<off_t>(length_), SEEK_SET) != 0 ||
      std::fwrite(block.data(), 1, block.size(), file_) != block.size())
    return FileError("cannot write", path_, errno);
  length_ += block.size();
  return {};
}

Result<void> BlockSpool::Flush() {
  if (std::fflush(file_) != 0) return FileError("cannot write", path_, errno);
  return {};
}

Result<std::string> BlockSpool::Read(std::uint64_t offset, std::uint64_t bytes) {
  std::string block(bytes, '\0');
  errno = EIO;  // where the file ends early
  if (fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fread(block.data(), 1, block.size(), file_) != block.size())
    return FileError("cannot read", path_, errno);
  return block;
}

}  // namespace skyquilt::storage
