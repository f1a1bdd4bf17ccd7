// PictureFormat: how the picture of a tile is encoded, and what each standard calls it; TileEncoding: which
// of them the tiles of a map are. One table, from which addresses, answers, contracts' texts and containers
// take their names. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::image {

enum class PictureFormat : std::uint8_t { kJpeg, kPng, kWebp };

struct PictureFormatRow {
  PictureFormat format;
  const char* extension;     // of an address, and what MBTiles calls it
  const char* content_type;  // in HTTP
  const char* name;          // of f= in OGC's APIs
  int pmtiles_type;          // in the head of a PMTiles archive (specification 3, "Tile Type"); 0: of none
  int mbtiles_code;  // in the column `tile_format` of our own MBTiles (those without it: stored_tiles.cc)
  std::string_view begins;  // first bytes of every such picture
  std::string_view at_8;    // and those behind its eighth, where the first do not tell
};

// In the order in which they are offered: who takes the first has what every program shows, at the map's edge
// too.
inline constexpr std::array kPictureFormats = {
    PictureFormatRow{PictureFormat::kPng, "png", "image/png", "png", 2, 2, "\x89PNG\r\n\x1a\n", ""},
    PictureFormatRow{PictureFormat::kJpeg, "jpg", "image/jpeg", "jpeg", 3, 0, "\xff\xd8\xff", ""},
    PictureFormatRow{PictureFormat::kWebp, "webp", "image/webp", "webp", 4, 1, "RIFF", "WEBP"},
};

// Of the tiles of a map.
enum class TileEncoding : std::uint8_t {
  kJpegPng,   // JPEG inside, PNG at the fringe
  kWebp,      // WebP throughout
  kJpegWebp,  // JPEG inside, WebP at the fringe
};

// By the first bytes; nothing for any other format.
std::optional<PictureFormat> PictureFormatOf(std::string_view bytes);
// A WebP whose head says that pixels may be transparent (RFC 9649, 2.5 to 2.7).
bool IsWebpWithAlpha(std::string_view bytes);

// "image/png"
const char* ContentTypeOf(PictureFormat format);
// "png"
const char* ExtensionOf(PictureFormat format);
// By extension or name, as they stand in the table.
std::optional<PictureFormat> PictureFormatNamed(std::string_view word);
int PmtilesTypeOf(PictureFormat format);
std::optional<PictureFormat> PictureFormatOfPmtiles(int type);
int MbtilesCodeOf(PictureFormat format);
std::optional<PictureFormat> PictureFormatOfMbtiles(std::int64_t code);

// What a user may ask for, in words: "image/png, image/jpeg and image/webp", each behind `before`.
std::string ListedFormats(const char* PictureFormatRow::*word, std::string_view before = {});

}  // namespace skyquilt::image
