#include "storage/exports/streamed/cog_cells.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/picture_codec.h"
#include "storage/exports/fringe_tile.h"

namespace skyquilt::storage {
namespace {

std::string Deflated(const std::vector<std::uint8_t>& bits) {
  uLongf size = compressBound(bits.size());
  std::string out(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(out.data()), &size, bits.data(), bits.size(), 6);
  SKYQUILT_CHECK(code == Z_OK, "a buffer of the asked size did not hold the mask");
  out.resize(size);
  return out;
}

std::size_t RowBytes(int side_px) { return (static_cast<std::size_t>(side_px) + 7) / 8; }

std::string FullMask(int side_px) {
  return Deflated(std::vector<std::uint8_t>(RowBytes(side_px) * static_cast<std::size_t>(side_px), 0xff));
}

// A JPEG of the same picture that takes `more` bytes more: comments behind its first marker, and, as any
// marker may have them before it, up to three fill bytes. ITU-T T.81, B.1.1.2 and B.2.4.5.
std::string Lengthened(std::string_view jpeg, std::uint64_t more) {
  constexpr std::uint64_t kCommentHeadBytes = 4, kMaxCommentBytes = 2 + 0xffff;
  std::string out(jpeg.substr(0, 2));
  while (more >= kCommentHeadBytes) {
    const std::uint64_t taken = std::min(more, kMaxCommentBytes);
    const std::uint64_t stated = taken - 2;
    out += "\xff\xfe";
    out += static_cast<char>(stated >> 8);
    out += static_cast<char>(stated & 0xff);
    out.append(taken - kCommentHeadBytes, '\0');
    more -= taken;
  }
  out.append(more, '\xff');
  out += jpeg.substr(2);
  return out;
}

// By squares of so many pixels, what most of them are.
std::vector<std::uint8_t> Coarser(const std::vector<std::uint8_t>& bits, int side_px, int square_px) {
  const std::size_t row_bytes = RowBytes(side_px);
  const auto is_set = [&](int x, int y) {
    const std::uint8_t byte = bits[static_cast<std::size_t>(y) * row_bytes + static_cast<std::size_t>(x) / 8];
    return (byte >> (7 - x % 8) & 1) != 0;
  };
  std::vector<std::uint8_t> out(bits.size(), 0);
  for (int top = 0; top < side_px; top += square_px) {
    for (int left = 0; left < side_px; left += square_px) {
      const int bottom = std::min(side_px, top + square_px), right = std::min(side_px, left + square_px);
      int set = 0;
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) set += is_set(x, y) ? 1 : 0;
      }
      if (2 * set < (bottom - top) * (right - left)) continue;
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          out[static_cast<std::size_t>(y) * row_bytes + static_cast<std::size_t>(x) / 8] |=
              static_cast<std::uint8_t>(0x80 >> (x % 8));
        }
      }
    }
  }
  return out;
}

std::string MaskWithin(const std::vector<std::uint8_t>& bits, int side_px, std::uint64_t room) {
  std::string mask = Deflated(bits);
  for (int square_px = 2; mask.size() > room && square_px <= side_px; square_px *= 2)
    mask = Deflated(Coarser(bits, side_px, square_px));
  SKYQUILT_CHECK(mask.size() <= room, "a mask of one value took more than the least room");
  // Readers stop at the end of the deflated stream.
  mask.resize(room, '\0');
  return mask;
}

// All of one colour, the mean of what is covered.
image::RgbaImage Flat(const image::RgbaImage& pixels) {
  std::array<std::uint64_t, 4> sum{};
  for (std::size_t at = 0; at + 3 < pixels.rgba.size(); at += 4) {
    if (pixels.rgba[at + 3] < 128) continue;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += pixels.rgba[at + c];
    ++sum[3];
  }
  image::RgbaImage flat = pixels;
  if (sum[3] == 0) return flat;
  for (std::size_t at = 0; at + 3 < flat.rgba.size(); at += 4) {
    for (std::size_t c = 0; c < 3; ++c) flat.rgba[at + c] = static_cast<std::uint8_t>(sum[c] / sum[3]);
  }
  return flat;
}

image::PictureFormat CopiedFormat(TiffTiles kind) {
  return kind == TiffTiles::kWebp ? image::PictureFormat::kWebp : image::PictureFormat::kJpeg;
}

// Empty: the tileset has no such tile.
Result<std::string> LoadTile(const geo::TileId& tile, MapTiles& tiles) {
  SKYQUILT_TRY_ASSIGN(std::optional<FoundTile> found, tiles.Find(tile));
  if (!found) return std::string();
  return tiles.Load(*std::move(found));
}

}  // namespace

void AppendBlock(std::string_view block, std::string& out) {
  const auto size = static_cast<std::uint32_t>(block.size());
  out.append(reinterpret_cast<const char*>(&size), kBlockSizeBytes);
  out += block;
  out += block.substr(block.size() - (kBlockFrameBytes - kBlockSizeBytes));
}

CogCells::CogCells(TiffTiles kind, int tile_size_px, int quality)
    : kind_(kind), tile_size_px_(tile_size_px), quality_(quality), full_mask_(FullMask(tile_size_px)) {}

bool CogCells::IsCopied(image::PictureFormat format) const { return format == CopiedFormat(kind_); }

CogRoom CogCells::LeastRoom() const {
  const auto side = static_cast<std::uint64_t>(tile_size_px_);
  // A JPEG of one colour takes 32 bits for each square of 16 pixels, and its tables; masks of a line across a
  // tile some two bytes a row.
  return {side * side / 64 + 1024, kind_ == TiffTiles::kJpeg ? 2 * side + 512 : 0};
}

Result<CogCell> CogCells::Make(const GridLevel& level, std::int64_t cell, MapTiles& tiles) const {
  SKYQUILT_TRY_ASSIGN(std::optional<CogCell> copied, Copied(level, cell, tiles));
  if (copied) return *std::move(copied);
  SKYQUILT_TRY_ASSIGN(const std::optional<image::RgbaImage> pixels, PixelsOf(level, cell, tiles));
  return pixels ? Encode(*pixels) : CogCell{};
}

Result<CogCell> CogCells::MakeWithin(const GridLevel& level, std::int64_t cell, std::uint64_t bytes,
                                     MapTiles& tiles) const {
  SKYQUILT_TRY_ASSIGN(std::optional<CogCell> copied, Copied(level, cell, tiles));
  if (copied) return *std::move(copied);
  SKYQUILT_TRY_ASSIGN(const std::optional<image::RgbaImage> pixels, PixelsOf(level, cell, tiles));
  const CogRoom least = LeastRoom();
  if (!pixels || bytes < least.Sum())
    return Error{ErrorCode::kCorrupt, "A tile of the map is damaged. Stitch the flight again.", ""};
  return Fitted(*pixels, {bytes - least.mask, least.mask});
}

Result<std::optional<CogCell>> CogCells::Copied(const GridLevel& level, std::int64_t cell,
                                                MapTiles& tiles) const {
  if (!level.IsAligned()) return std::optional<CogCell>();
  SKYQUILT_TRY_ASSIGN(std::string bytes, LoadTile(*level.TileOf(cell), tiles));
  const auto format = image::PictureFormatOf(bytes);
  if (!format || !IsCopied(*format)) return std::optional<CogCell>();
  return std::optional<CogCell>(
      CogCell{std::move(bytes), kind_ == TiffTiles::kJpeg ? full_mask_ : std::string()});
}

Result<std::optional<image::RgbaImage>> CogCells::PixelsOfBytes(const std::string& bytes) const {
  if (bytes.empty()) return std::optional<image::RgbaImage>();
  SKYQUILT_TRY_ASSIGN(image::RgbaImage pixels, DecodeTile(bytes, tile_size_px_));
  return std::optional<image::RgbaImage>(std::move(pixels));
}

Result<std::optional<image::RgbaImage>> CogCells::PixelsOf(const GridLevel& level, std::int64_t cell,
                                                           MapTiles& tiles) const {
  if (level.IsAligned()) {
    SKYQUILT_TRY_ASSIGN(const std::string bytes, LoadTile(*level.TileOf(cell), tiles));
    return PixelsOfBytes(bytes);
  }
  // Put together from the up to four tiles that it lies over.
  std::optional<image::RgbaImage> composed;
  for (int south = 0; south <= (level.shift_y_px > 0 ? 1 : 0); ++south) {
    for (int east = 0; east <= (level.shift_x_px > 0 ? 1 : 0); ++east) {
      const std::optional<geo::TileId> tile = level.TileOf(cell, east, south);
      if (!tile) continue;
      SKYQUILT_TRY_ASSIGN(const std::string bytes, LoadTile(*tile, tiles));
      SKYQUILT_TRY_ASSIGN(const std::optional<image::RgbaImage> canvas, PixelsOfBytes(bytes));
      if (!canvas) continue;
      if (!composed) composed = image::RgbaImage::Transparent(tile_size_px_, tile_size_px_);
      // The tile's corner in the cell.
      const int left = east * tile_size_px_ - level.shift_x_px,
                top = south * tile_size_px_ - level.shift_y_px;
      const int from_x = std::max(0, left), to_x = std::min(tile_size_px_, left + tile_size_px_);
      for (int y = std::max(0, top); y < std::min(tile_size_px_, top + tile_size_px_); ++y) {
        std::memcpy(composed->Pixel(from_x, y), canvas->Pixel(from_x - left, y - top),
                    4 * static_cast<std::size_t>(to_x - from_x));
      }
    }
  }
  return composed;
}

CogCell CogCells::Encode(const image::RgbaImage& pixels) const {
  CogCell cell;
  if (kind_ == TiffTiles::kWebp) {
    const auto webp = image::EncodeWebp(image::RowsOf(pixels), static_cast<float>(quality_));
    cell.image.assign(webp.begin(), webp.end());
    return cell;
  }
  FringeTile fringe = SplitAlpha(pixels, quality_);
  if (fringe.is_empty) return cell;
  cell.image = std::move(fringe.jpeg);
  cell.mask = Deflated(fringe.mask_bits);
  return cell;
}

CogCell CogCells::Fitted(const image::RgbaImage& pixels, const CogRoom& room) const {
  CogCell cell;
  if (kind_ == TiffTiles::kWebp) {
    for (const int quality : {quality_, quality_ * 3 / 4, quality_ / 2, quality_ / 4, 1, 0}) {
      const auto webp =
          image::EncodeWebp(image::RowsOf(quality > 0 ? pixels : Flat(pixels)), static_cast<float>(quality));
      cell.image.assign(webp.begin(), webp.end());
      if (cell.image.size() <= room.image) break;
    }
    SKYQUILT_CHECK(cell.image.size() <= room.image, "a WebP of one colour took more than the least room");
    // Its own head says where it ends.
    cell.image.resize(room.image, '\0');
    return cell;
  }
  FringeTile fringe;
  for (const int quality : {quality_, quality_ * 7 / 8, quality_ * 3 / 4, quality_ / 2, quality_ / 4, 1, 0}) {
    fringe = SplitAlpha(quality > 0 ? pixels : Flat(pixels), std::max(1, quality));
    if (fringe.jpeg.size() <= room.image) break;
  }
  SKYQUILT_CHECK(fringe.jpeg.size() <= room.image, "a JPEG of one colour took more than the least room");
  cell.image = Lengthened(fringe.jpeg, room.image - fringe.jpeg.size());
  cell.mask = MaskWithin(fringe.mask_bits, tile_size_px_, room.mask);
  return cell;
}

}  // namespace skyquilt::storage
