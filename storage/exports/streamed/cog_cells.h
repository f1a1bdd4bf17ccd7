// CogCells: the cells of a GeoTIFF as its tiles hold them, made from the tiles of a map. Where a cell is a
// tile of the same compression, the tile's own bytes; else the cell is decoded, put together and encoded
// anew, as JPEG with a one-bit mask, or as WebP. Any number of threads. Errors: kCorrupt, those of the
// tileset.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/image/rgba_image.h"
#include "storage/exports/stored_tiles.h"
#include "storage/exports/tiff_head.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// What stands before a block's bytes, its size, and with it what stands behind: its last bytes once more.
inline constexpr std::uint64_t kBlockSizeBytes = 4, kBlockFrameBytes = 8;

// A block as the note on the order of the file promises it (TiffHead).
void AppendBlock(std::string_view block, std::string& out);

struct CogCell {
  std::string image;  // empty: nothing is shown here
  std::string mask;   // deflated; empty with WebP
};

// Bytes that a cell takes or is to take.
struct CogRoom {
  std::uint64_t image = 0;
  std::uint64_t mask = 0;
  std::uint64_t Sum() const { return image + mask; }
};

class CogCells {
 public:
  CogCells(TiffTiles kind, int tile_size_px, int quality);

  // In as many bytes as it takes.
  Result<CogCell> Make(const GridLevel& level, std::int64_t cell, MapTiles& tiles) const;
  // What is encoded anew takes exactly so many, LeastRoom or more: it is filled up, and where it would take
  // more, its quality is lowered and its mask made coarser until it fits. What is copied stays as it is.
  Result<CogCell> MakeWithin(const GridLevel& level, std::int64_t cell, std::uint64_t bytes,
                             MapTiles& tiles) const;
  // Of pixels with straight alpha, as large as a tile.
  CogCell Encode(const image::RgbaImage& pixels) const;
  // `mask` of every cell that is encoded anew.
  CogRoom LeastRoom() const;
  // The mask of a tile that is covered everywhere.
  const std::string& full_mask() const { return full_mask_; }
  // True: cells that are tiles of this format are copied.
  bool IsCopied(image::PictureFormat format) const;
  // The pixels of a cell, straight alpha; absent: no tile lies below it.
  Result<std::optional<image::RgbaImage>> PixelsOf(const GridLevel& level, std::int64_t cell,
                                                   MapTiles& tiles) const;

 private:
  // The tile that a cell is, where its bytes are copied.
  Result<std::optional<CogCell>> Copied(const GridLevel& level, std::int64_t cell, MapTiles& tiles) const;
  Result<std::optional<image::RgbaImage>> PixelsOfBytes(const std::string& bytes) const;
  CogCell Fitted(const image::RgbaImage& pixels, const CogRoom& room) const;

  const TiffTiles kind_;
  const int tile_size_px_;
  const int quality_;
  const std::string full_mask_;
};

}  // namespace skyquilt::storage
