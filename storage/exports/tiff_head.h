// TiffHead: everything of a cloud-optimised GeoTIFF that stands before its tiles: header, GDAL's note on the
// order of the file, and all directories with room for the places of their tiles, which are filled in as
// tiles are written. Memory: 12 or 16 bytes per tile. One thread. Sources: TIFF 6.0; BigTIFF; GeoTIFF 1.1
// (OGC 19-008r4); COG layout as GDAL's COG driver documents it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "storage/exports/stored_tiles.h"

namespace skyquilt::storage {

enum class TiffTiles { kJpeg, kWebp };

// Where the finest level lies: the corner in the north-west and a pixel's sides, in units of the system.
struct TiffPlace {
  int epsg = 0;
  bool is_geographic = false, is_in_degrees = false;
  std::string name;  // of the system
  double west = 0.0, north = 0.0, pixel_x = 1.0, pixel_y = 1.0;
};

class TiffHead {
 public:
  // With JPEG every level has a directory of one-bit masks beside it; WebP carries alpha itself.
  // `expected_bytes`: of the file; of large ones places have 64 bits (BigTIFF).
  TiffHead(const std::vector<GridLevel>& grid, int tile_size_px, TiffTiles tiles,
           std::uint64_t expected_bytes, const TiffPlace& place);
  // Of a map on the web map's own tiles: its place follows from them, and a reader learns of the scheme.
  TiffHead(const std::vector<GridLevel>& grid, int tile_size_px, TiffTiles tiles,
           std::uint64_t expected_bytes);

  // Where a tile of a level begins in the file, and its size; cells without a tile stay at zero.
  void SetTile(std::size_t level, std::int64_t cell, std::uint64_t offset, std::uint64_t size);
  void SetMask(std::size_t level, std::int64_t cell, std::uint64_t offset, std::uint64_t size);
  // The bytes from the start of the file to the first tile.
  const std::string& bytes() const { return bytes_; }

 private:
  struct Entry {
    std::uint16_t tag = 0;
    std::uint16_t type = 0;
    std::uint64_t count = 0;
    std::string value;
  };
  struct TileArrays {
    std::size_t offsets_at = 0;  // position in bytes_
    std::size_t sizes_at = 0;
  };
  std::vector<Entry> EntriesOf(const GridLevel& level, bool is_overview, bool is_mask) const;
  void AddLevels(const std::vector<GridLevel>& grid, std::vector<Entry> of_finest);
  static std::vector<Entry> GeoEntries(const TiffPlace& place);
  Entry SchemeEntry(const GridLevel& level) const;
  TileArrays AddDirectory(std::vector<Entry> entries);
  void Set(const TileArrays& arrays, std::int64_t cell, std::uint64_t offset, std::uint64_t size);
  int OffsetSize() const { return is_big_ ? 8 : 4; }

  const int tile_size_px_;
  const TiffTiles tiles_;
  const bool is_big_;
  std::string bytes_;
  std::size_t next_directory_at_ = 0;  // where the place of the next directory must be written
  std::vector<TileArrays> images_;
  std::vector<TileArrays> masks_;
};

}  // namespace skyquilt::storage
