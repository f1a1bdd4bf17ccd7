#include "storage/exports/cog_writer.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "storage/exports/streamed/cog_cells.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

// Where its own bytes begin.
std::uint64_t WriteBlock(StreamFile& file, std::string_view block) {
  const std::uint64_t at = file.position() + kBlockSizeBytes;
  std::string framed;
  AppendBlock(block, framed);
  file.Write(framed);
  return at;
}

}  // namespace

Result<CogLayout> CogLayoutOf(SqliteDb& mbtiles, const TilesetFacts& metadata) {
  const bool is_webp = EncodingOf(metadata) == image::TileEncoding::kWebp;
  CogLayout layout;
  layout.tile_size_px = TilesetNumber(metadata, "tile_size", 256);
  layout.tiles = is_webp ? TiffTiles::kWebp : TiffTiles::kJpeg;
  SKYQUILT_TRY_ASSIGN(layout.grid, GridOf(mbtiles, layout.tile_size_px,
                                          is_webp ? GridAlignment::kAllLevels : GridAlignment::kFineLevels));
  return layout;
}

std::uint64_t MostCogBytes(const CogLayout& layout, const std::vector<TableTile>& table) {
  const auto side = static_cast<std::uint64_t>(layout.tile_size_px);
  const std::uint64_t encoded_anew = side * side * 4;  // as pixels; of any quality, with its mask
  const CogCells cells(layout.tiles, layout.tile_size_px, /*quality=*/0);
  std::uint64_t bytes = 0;
  for (const TableTile& tile : table)
    bytes += cells.IsCopied(tile.format) ? tile.bytes + cells.full_mask().size() : encoded_anew;
  for (const GridLevel& level : layout.grid) {
    constexpr std::uint64_t kFramesAndPlaces = 64;
    bytes += static_cast<std::uint64_t>(level.CellCount()) *
             (kFramesAndPlaces + (level.IsAligned() ? 0 : encoded_anew));
  }
  return bytes;
}

Result<void> WriteCog(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      const CogOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(auto tiles, MbtilesReader::Open(mbtiles));
  CogLayout layout;
  std::uint64_t most_bytes = 0;
  {
    SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
    SKYQUILT_TRY_ASSIGN(layout, CogLayoutOf(db, tiles->metadata()));
    SKYQUILT_TRY(CheckCells(layout.grid.front()));
    SKYQUILT_TRY_ASSIGN(const std::vector<TableTile> table, ReadTileTable(db));
    most_bytes = MostCogBytes(layout, table);
  }
  const std::vector<GridLevel>& grid = layout.grid;
  const TiffTiles kind = layout.tiles;
  std::int64_t cells = 0;
  for (const GridLevel& level : grid) cells += level.CellCount();

  TiffHead head(grid, layout.tile_size_px, kind, most_bytes);
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(head.bytes());
  const CogCells work(kind, layout.tile_size_px, options.jpeg_quality);
  std::int64_t done = 0;
  // The smallest overview first: a reader that fetches the file's beginning has a picture at once.
  for (std::size_t level = grid.size(); level-- > 0;) {
    const GridLevel& cells_of = grid[level];
    std::optional<Error> failure;
    const std::size_t window = 4 * static_cast<std::size_t>(ThreadCount(options.threads)) + 4;
    ParallelOrdered<Result<CogCell>>(
        static_cast<std::size_t>(cells_of.CellCount()), options.threads, window,
        [&](std::size_t cell) -> Result<CogCell> {
          if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
          return work.Make(cells_of, static_cast<std::int64_t>(cell), *tiles);
        },
        [&](std::size_t cell, Result<CogCell>&& ready) {
          if (failure) return;
          if (!ready) {
            failure = ready.error();
            return;
          }
          ++done;
          if (ready->image.empty()) return;
          const auto number = static_cast<std::int64_t>(cell);
          head.SetTile(level, number, WriteBlock(*file, ready->image), ready->image.size());
          if (kind == TiffTiles::kJpeg)
            head.SetMask(level, number, WriteBlock(*file, ready->mask), ready->mask.size());
          progress.Report(static_cast<double>(done) / static_cast<double>(cells), "writing GeoTIFF");
        });
    if (failure) return *failure;
  }
  file->WriteAt(0, head.bytes());
  return file->Publish();
}

namespace {

constexpr int kStreamedCogQuality = 85;  // of tiles encoded anew
// A cell among those of all levels.
constexpr int kLevelShift = 48;

const TableTile* FindTile(const std::vector<TableTile>& table, const std::optional<geo::TileId>& tile) {
  if (!tile) return nullptr;
  const auto found = std::lower_bound(table.begin(), table.end(), *tile,
                                      [](const TableTile& a, const geo::TileId& b) { return a.tile < b; });
  return found != table.end() && found->tile == *tile ? &*found : nullptr;
}

// What a tile takes when it is encoded anew, hardly ever more. Measured on maps of real flights: a WebP of
// the map's edge becomes a JPEG of 1.1 to 2 times its size, a PNG one of a third or less.
std::uint64_t ExpectedBytes(const TableTile& tile) {
  const auto bytes = static_cast<std::uint64_t>(tile.bytes);
  return tile.format == image::PictureFormat::kPng    ? bytes * 2 / 5
         : tile.format == image::PictureFormat::kWebp ? bytes * 2
                                                      : bytes * 5 / 4;
}

class StreamedCog final : public StreamedFile {
 public:
  StreamedCog(std::string head, std::vector<StreamedPiece> pieces, std::uint64_t length,
              std::vector<GridLevel> grid, CogCells cells)
      : StreamedFile(std::move(head), std::move(pieces), length),
        grid_(std::move(grid)),
        cells_(std::move(cells)) {}

  static std::int64_t WhatOf(std::size_t level, std::int64_t cell) {
    return static_cast<std::int64_t>(level) << kLevelShift | cell;
  }

 protected:
  Result<std::string> Make(std::int64_t what, std::uint64_t bytes, MapTiles& tiles) const override {
    const GridLevel& level = grid_[static_cast<std::size_t>(what >> kLevelShift)];
    const std::int64_t number = what & ((std::int64_t{1} << kLevelShift) - 1);
    const std::uint64_t frames = kBlockFrameBytes * (cells_.LeastRoom().mask > 0 ? 2 : 1);
    SKYQUILT_TRY_ASSIGN(const CogCell cell, cells_.MakeWithin(level, number, bytes - frames, tiles));
    std::string piece;
    piece.reserve(bytes);
    AppendBlock(cell.image, piece);
    if (!cell.mask.empty()) AppendBlock(cell.mask, piece);
    return piece;
  }

 private:
  const std::vector<GridLevel> grid_;
  const CogCells cells_;
};

// The bytes of each cell of a level; nothing where no tile lies below.
std::optional<CogRoom> RoomOf(const GridLevel& level, std::int64_t cell, const std::vector<TableTile>& table,
                              const CogCells& cells) {
  CogRoom room = cells.LeastRoom();
  if (level.IsAligned()) {
    const TableTile* tile = FindTile(table, level.TileOf(cell));
    if (tile == nullptr) return std::nullopt;
    if (cells.IsCopied(tile->format))
      return CogRoom{tile->bytes, room.mask > 0 ? cells.full_mask().size() : 0};
    room.image += ExpectedBytes(*tile);
    return room;
  }
  std::uint64_t largest = 0;
  for (int south = 0; south <= (level.shift_y_px > 0 ? 1 : 0); ++south) {
    for (int east = 0; east <= (level.shift_x_px > 0 ? 1 : 0); ++east) {
      const TableTile* tile = FindTile(table, level.TileOf(cell, east, south));
      if (tile != nullptr) largest = std::max(largest, ExpectedBytes(*tile));
    }
  }
  if (largest == 0) return std::nullopt;
  room.image += largest;
  return room;
}

}  // namespace

Result<std::shared_ptr<const StreamedFile>> LayOutCog(SqliteDb& mbtiles, const TilesetFacts& metadata) {
  SKYQUILT_TRY_ASSIGN(const std::vector<TableTile> table, ReadTileTable(mbtiles));
  SKYQUILT_TRY_ASSIGN(CogLayout layout, CogLayoutOf(mbtiles, metadata));
  SKYQUILT_TRY(CheckCells(layout.grid.front()));
  auto& [tile_size_px, kind, grid] = layout;
  CogCells cells(kind, tile_size_px, kStreamedCogQuality);
  struct Placed {
    std::size_t level;
    std::int64_t cell;
    CogRoom room;
  };
  std::vector<Placed> placed;
  std::uint64_t bytes = 0;
  const std::uint64_t frames = kBlockFrameBytes * (kind == TiffTiles::kJpeg ? 2 : 1);
  // The smallest overview first: a reader that fetches the file's beginning has a picture at once.
  for (std::size_t level = grid.size(); level-- > 0;) {
    for (std::int64_t cell = 0; cell < grid[level].CellCount(); ++cell) {
      const std::optional<CogRoom> room = RoomOf(grid[level], cell, table, cells);
      if (!room) continue;
      placed.push_back({level, cell, *room});
      bytes += room->Sum() + frames;
    }
  }
  TiffHead head(grid, tile_size_px, kind, bytes);
  std::vector<StreamedPiece> pieces;
  pieces.reserve(placed.size());
  std::uint64_t at = head.bytes().size();
  for (const Placed& one : placed) {
    pieces.push_back({at, StreamedCog::WhatOf(one.level, one.cell)});
    head.SetTile(one.level, one.cell, at + kBlockSizeBytes, one.room.image);
    if (kind == TiffTiles::kJpeg)
      head.SetMask(one.level, one.cell, at + kBlockFrameBytes + one.room.image + kBlockSizeBytes,
                   one.room.mask);
    at += one.room.Sum() + frames;
  }
  return std::shared_ptr<const StreamedFile>(std::make_shared<const StreamedCog>(
      head.bytes(), std::move(pieces), at, std::move(grid), std::move(cells)));
}

}  // namespace skyquilt::storage
