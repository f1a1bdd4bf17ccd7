#include "storage/tilesets/tile_source.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::storage {

Result<std::string> TileSource::Load(FoundTile tile) {
  SKYQUILT_CHECK(tile.bytes.has_value(), "a tile was to be loaded that Find did not answer");
  return *std::move(tile.bytes);
}

image::TileEncoding EncodingOf(const TilesetFacts& metadata) {
  return TilesetText(metadata, "fringe") == "webp"   ? image::TileEncoding::kJpegWebp
         : TilesetText(metadata, "format") == "webp" ? image::TileEncoding::kWebp
                                                     : image::TileEncoding::kJpegPng;
}

std::string TilesetText(const TilesetFacts& metadata, const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : found->second;
}

int TilesetNumber(const TilesetFacts& metadata, const char* key, int fallback) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) return fallback;
  int number = fallback;
  std::from_chars(found->second.data(), found->second.data() + found->second.size(), number);
  return number;
}

std::optional<geo::LatLonBounds> TilesetBounds(const TilesetFacts& metadata) {
  const auto found = metadata.find("bounds");
  std::array<double, 4> box{};
  if (found == metadata.end() ||
      std::sscanf(found->second.c_str(), "%lf,%lf,%lf,%lf", &box[0], &box[1], &box[2], &box[3]) != 4)
    return std::nullopt;
  return geo::LatLonBounds::FromArray(box);
}

}  // namespace skyquilt::storage
