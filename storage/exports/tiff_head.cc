#include "storage/exports/tiff_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <utility>

#include "core/geo/web_mercator.h"

namespace skyquilt::storage {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the file is written in the byte order of the machine");

enum Type : std::uint16_t { kAscii = 2, kShort = 3, kLong = 4, kDouble = 12, kLong8 = 16 };

enum Tag : std::uint16_t {
  kNewSubfileType = 254,
  kImageWidth = 256,
  kImageLength = 257,
  kBitsPerSample = 258,
  kCompression = 259,
  kPhotometric = 262,
  kSamplesPerPixel = 277,
  kPlanarConfiguration = 284,
  kTileWidth = 322,
  kTileLength = 323,
  kTileOffsets = 324,
  kTileByteCounts = 325,
  kExtraSamples = 338,
  kSampleFormat = 339,
  kYcbcrSubsampling = 530,
  kModelPixelScale = 33550,
  kModelTiepoint = 33922,
  kGeoKeyDirectory = 34735,
  kGeoAsciiParams = 34737,
  kGdalMetadata = 42112,
};

constexpr int kMercEpsg = 3857;
constexpr std::uint16_t kReducedImage = 1, kMaskImage = 4;
constexpr std::uint16_t kJpegCompression = 7, kDeflateCompression = 8, kWebpCompression = 50001;
constexpr std::uint16_t kRgb = 2, kMaskPhotometric = 4, kYcbcr = 6;
constexpr std::uint16_t kUnassociatedAlpha = 2;

template <typename T>
void Append(std::string& out, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  out.append(raw, sizeof(T));
}

template <typename T>
std::string Packed(std::initializer_list<T> values) {
  std::string out;
  for (const T value : values) Append(out, value);
  return out;
}

template <typename T>
void Overwrite(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

// Tells GDAL's reader what it may rely on: it then finds a tile's size and mask without asking the
// directories.
std::string StructureNote(bool has_masks) {
  std::string facts =
      "LAYOUT=IFDS_BEFORE_DATA\nBLOCK_ORDER=ROW_MAJOR\nBLOCK_LEADER=SIZE_AS_UINT4\n"
      "BLOCK_TRAILER=LAST_4_BYTES_REPEATED\nKNOWN_INCOMPATIBLE_EDITION=NO\n ";
  if (has_masks) facts += "MASK_INTERLEAVED_WITH_IMAGERY=YES\n";
  return fmt::format("GDAL_STRUCTURAL_METADATA_SIZE={:06} bytes\n{}", facts.size(), facts);
}

// Beyond this a classic TIFF's 32-bit places might not reach.
constexpr std::uint64_t kClassicTiffLimitBytes = std::uint64_t{3500} << 20;

}  // namespace

TiffHead::TiffHead(const std::vector<GridLevel>& grid, int tile_size_px, TiffTiles tiles,
                   std::uint64_t expected_bytes, const TiffPlace& place)
    : tile_size_px_(tile_size_px), tiles_(tiles), is_big_(expected_bytes > kClassicTiffLimitBytes) {
  AddLevels(grid, GeoEntries(place));
}

TiffHead::TiffHead(const std::vector<GridLevel>& grid, int tile_size_px, TiffTiles tiles,
                   std::uint64_t expected_bytes)
    : tile_size_px_(tile_size_px), tiles_(tiles), is_big_(expected_bytes > kClassicTiffLimitBytes) {
  const double tile_m = geo::TileSizeInMercM(grid[0].zoom);
  const double pixel_m = geo::PixelSizeInMercM(grid[0].zoom, tile_size_px);
  std::vector<Entry> entries =
      GeoEntries({kMercEpsg, false, false, "WGS 84 / Pseudo-Mercator",
                  static_cast<double>(grid[0].first_column) * tile_m - geo::kMercHalfWidthM,
                  geo::kMercHalfWidthM - static_cast<double>(grid[0].first_row) * tile_m, pixel_m, pixel_m});
  entries.push_back(SchemeEntry(grid[0]));
  AddLevels(grid, std::move(entries));
}

void TiffHead::AddLevels(const std::vector<GridLevel>& grid, std::vector<Entry> of_finest) {
  bytes_ = "II";
  if (is_big_) {
    bytes_ += Packed<std::uint16_t>({43, 8, 0});
    next_directory_at_ = bytes_.size();
    Append<std::uint64_t>(bytes_, 0);
  } else {
    Append<std::uint16_t>(bytes_, 42);
    next_directory_at_ = bytes_.size();
    Append<std::uint32_t>(bytes_, 0);
  }
  const bool has_masks = tiles_ == TiffTiles::kJpeg;
  bytes_ += StructureNote(has_masks);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    std::vector<Entry> image = EntriesOf(grid[i], i > 0, false);
    if (i == 0) std::move(of_finest.begin(), of_finest.end(), std::back_inserter(image));
    images_.push_back(AddDirectory(std::move(image)));
    if (has_masks) masks_.push_back(AddDirectory(EntriesOf(grid[i], i > 0, true)));
  }
}

std::vector<TiffHead::Entry> TiffHead::EntriesOf(const GridLevel& level, bool is_overview,
                                                 bool is_mask) const {
  const bool is_jpeg = tiles_ == TiffTiles::kJpeg;
  const auto cells = static_cast<std::uint64_t>(level.CellCount());
  const int samples = is_mask ? 1 : is_jpeg ? 3 : 4;
  std::vector<Entry> entries;
  const auto add_long = [&](Tag tag, std::int64_t value) {
    entries.push_back({tag, kLong, 1, Packed({static_cast<std::uint32_t>(value)})});
  };
  const auto add_shorts = [&](Tag tag, int value, int times = 1) {
    std::string values;
    for (int i = 0; i < times; ++i) Append(values, static_cast<std::uint16_t>(value));
    entries.push_back({tag, kShort, static_cast<std::uint64_t>(times), std::move(values)});
  };
  add_long(kImageWidth, level.width_px);
  add_long(kImageLength, level.height_px);
  add_shorts(kTileWidth, tile_size_px_);
  add_shorts(kTileLength, tile_size_px_);
  entries.push_back({kTileOffsets, is_big_ ? kLong8 : kLong, cells, std::string(cells * OffsetSize(), '\0')});
  entries.push_back({kTileByteCounts, kLong, cells, std::string(cells * 4, '\0')});
  add_shorts(kPlanarConfiguration, 1);
  if (is_mask || is_overview)
    add_long(kNewSubfileType, (is_mask ? kMaskImage : 0) | (is_overview ? kReducedImage : 0));
  add_shorts(kBitsPerSample, is_mask ? 1 : 8, samples);
  add_shorts(kSampleFormat, 1, samples);
  add_shorts(kSamplesPerPixel, samples);
  add_shorts(kCompression, is_mask ? kDeflateCompression : is_jpeg ? kJpegCompression : kWebpCompression);
  add_shorts(kPhotometric, is_mask ? kMaskPhotometric : is_jpeg ? kYcbcr : kRgb);
  if (is_jpeg && !is_mask) add_shorts(kYcbcrSubsampling, 2, 2);
  if (!is_jpeg) add_shorts(kExtraSamples, kUnassociatedAlpha);
  return entries;
}

std::vector<TiffHead::Entry> TiffHead::GeoEntries(const TiffPlace& place) {
  // Names of GeoTIFF's keys, each with the value's place (0: here), their number and the value.
  enum Key : std::uint16_t {
    kModelType = 1024,
    kRasterType = 1025,
    kCitation = 1026,
    kGeodeticSystem = 2048,
    kAngularUnits = 2054,
    kProjectedSystem = 3072,
    kLinearUnits = 3076,
  };
  constexpr std::uint16_t kProjected = 1, kGeographic = 2, kPixelIsArea = 1, kMetre = 9001, kDegree = 9102;
  const std::string name = place.name + "|";
  const auto code = static_cast<std::uint16_t>(place.epsg);
  std::string keys;
  std::uint16_t count = 0;
  const auto add = [&](std::uint16_t key, std::uint16_t at, std::uint16_t values, std::uint16_t value) {
    keys += Packed<std::uint16_t>({key, at, values, value});
    ++count;
  };
  add(kModelType, 0, 1, place.is_geographic ? kGeographic : kProjected);
  add(kRasterType, 0, 1, kPixelIsArea);
  add(kCitation, kGeoAsciiParams, static_cast<std::uint16_t>(name.size()), 0);
  add(place.is_geographic ? kGeodeticSystem : kProjectedSystem, 0, 1, code);
  if (place.is_in_degrees) add(kAngularUnits, 0, 1, kDegree);
  if (place.epsg == kMercEpsg) add(kLinearUnits, 0, 1, kMetre);  // of others the code says it
  return {{kModelPixelScale, kDouble, 3, Packed<double>({place.pixel_x, place.pixel_y, 0.0})},
          {kModelTiepoint, kDouble, 6, Packed<double>({0.0, 0.0, 0.0, place.west, place.north, 0.0})},
          {kGeoKeyDirectory, kShort, 4 + 4ULL * count, Packed<std::uint16_t>({1, 1, 0, count}) + keys},
          {kGeoAsciiParams, kAscii, name.size() + 1, name + '\0'}};
}

TiffHead::Entry TiffHead::SchemeEntry(const GridLevel& level) const {
  // The zoom as the well-known scale set of 256-pixel tiles counts it.
  const int zoom_of_256 = level.zoom + std::countr_zero(static_cast<unsigned>(tile_size_px_)) - 8;
  const std::string metadata = fmt::format(
      "<GDALMetadata>\n  <Item name=\"NAME\" domain=\"TILING_SCHEME\">GoogleMapsCompatible</Item>\n"
      "  <Item name=\"ZOOM_LEVEL\" domain=\"TILING_SCHEME\">{}</Item>\n</GDALMetadata>\n",
      zoom_of_256);
  return {kGdalMetadata, kAscii, metadata.size() + 1, metadata + '\0'};
}

TiffHead::TileArrays TiffHead::AddDirectory(std::vector<Entry> entries) {
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
  bytes_.resize((bytes_.size() + 1) / 2 * 2, '\0');
  const std::size_t start = bytes_.size();
  if (is_big_) {
    Overwrite<std::uint64_t>(bytes_, next_directory_at_, start);
    Append<std::uint64_t>(bytes_, entries.size());
  } else {
    Overwrite<std::uint32_t>(bytes_, next_directory_at_, static_cast<std::uint32_t>(start));
    Append<std::uint16_t>(bytes_, static_cast<std::uint16_t>(entries.size()));
  }
  const auto inline_size = static_cast<std::size_t>(OffsetSize());
  std::vector<std::size_t> value_at(entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    Append<std::uint16_t>(bytes_, entries[i].tag);
    Append<std::uint16_t>(bytes_, entries[i].type);
    if (is_big_) Append<std::uint64_t>(bytes_, entries[i].count);
    if (!is_big_) Append<std::uint32_t>(bytes_, static_cast<std::uint32_t>(entries[i].count));
    value_at[i] = bytes_.size();
    bytes_.append(inline_size, '\0');
  }
  next_directory_at_ = bytes_.size();
  bytes_.append(inline_size, '\0');
  TileArrays arrays;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].value.size() > inline_size) {
      bytes_.resize((bytes_.size() + 7) / 8 * 8, '\0');
      if (is_big_) Overwrite<std::uint64_t>(bytes_, value_at[i], bytes_.size());
      if (!is_big_) Overwrite<std::uint32_t>(bytes_, value_at[i], static_cast<std::uint32_t>(bytes_.size()));
      value_at[i] = bytes_.size();
      bytes_ += entries[i].value;
    } else {
      std::memcpy(bytes_.data() + value_at[i], entries[i].value.data(), entries[i].value.size());
    }
    if (entries[i].tag == kTileOffsets) arrays.offsets_at = value_at[i];
    if (entries[i].tag == kTileByteCounts) arrays.sizes_at = value_at[i];
  }
  return arrays;
}

void TiffHead::Set(const TileArrays& arrays, std::int64_t cell, std::uint64_t offset, std::uint64_t size) {
  const auto i = static_cast<std::size_t>(cell);
  if (is_big_) Overwrite<std::uint64_t>(bytes_, arrays.offsets_at + 8 * i, offset);
  if (!is_big_)
    Overwrite<std::uint32_t>(bytes_, arrays.offsets_at + 4 * i, static_cast<std::uint32_t>(offset));
  Overwrite<std::uint32_t>(bytes_, arrays.sizes_at + 4 * i, static_cast<std::uint32_t>(size));
}

void TiffHead::SetTile(std::size_t level, std::int64_t cell, std::uint64_t offset, std::uint64_t size) {
  Set(images_[level], cell, offset, size);
}

void TiffHead::SetMask(std::size_t level, std::int64_t cell, std::uint64_t offset, std::uint64_t size) {
  Set(masks_[level], cell, offset, size);
}

}  // namespace skyquilt::storage
