// TileJudge: whether the tiles of a set are pictures of one size that can be decoded, and lie where the set
// says. Put in tile by tile, in any order; findings go to the verdict at the end. Memory: 8 bytes per tile,
// up to kMaxCoveredTiles. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::storage {

// What a set says of its tiles.
struct TilesetClaims {
  std::string format;  // "jpg", "png" or "webp"; empty: it does not say
  std::optional<int> min_zoom, max_zoom, tile_size_px;
  std::optional<geo::LatLonBounds> bounds;
};

class TileJudge {
 public:
  static constexpr std::size_t kMaxCoveredTiles = 20'000'000;

  // `quick`: of the pictures only one in fifty is decoded.
  explicit TileJudge(bool quick) : decodes_one_in_(quick ? 50 : 1) {}

  static std::string NameOf(const geo::TileId& tile);
  void Cover(const geo::TileId& tile);
  void LookAt(const geo::TileId& tile, std::string_view picture);
  CountedFindings& counted() { return counted_; }
  std::int64_t tiles() const { return tiles_; }

  void Finish(const TilesetClaims& claims, FileVerdict& verdict);

 private:
  void JudgePictures(const TilesetClaims& claims, FileVerdict& verdict) const;
  void JudgeZooms(const TilesetClaims& claims, FileVerdict& verdict) const;
  void JudgeParents(FileVerdict& verdict);
  void JudgeBounds(const TilesetClaims& claims, FileVerdict& verdict) const;
  int MinZoom() const;
  int MaxZoom() const;

  const int decodes_one_in_;
  CountedFindings counted_;
  std::array<std::vector<std::uint64_t>, geo::kMaxZoom + 1> by_zoom_;
  std::int64_t tiles_ = 0, pictures_ = 0;
  std::array<std::int64_t, image::kPictureFormats.size()> of_format_{};  // by image::PictureFormat
  int side_px_ = 0;
};

}  // namespace skyquilt::storage
