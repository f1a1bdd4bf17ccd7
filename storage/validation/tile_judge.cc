#include "storage/validation/tile_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::storage {
namespace {

constexpr double kLastLatDeg = 85.0511287798;

std::uint64_t PlaceInZoom(const geo::TileId& tile) { return std::uint64_t{tile.x()} << 32 | tile.y(); }

std::string TextOfBounds(const geo::LatLonBounds& b) {
  return fmt::format("{:.6f},{:.6f},{:.6f},{:.6f}", b.west_deg, b.south_deg, b.east_deg, b.north_deg);
}

bool AreBounds(const geo::LatLonBounds& b) {
  return b.west_deg < b.east_deg && b.south_deg < b.north_deg && b.west_deg >= -180.0 &&
         b.east_deg <= 540.0 && b.south_deg >= -90.0 && b.north_deg <= 90.0;
}

}  // namespace

std::string TileJudge::NameOf(const geo::TileId& tile) {
  return fmt::format("{}/{}/{}", tile.z(), tile.x(), tile.y());
}

void TileJudge::Cover(const geo::TileId& tile) {
  if (static_cast<std::size_t>(tiles_++) < kMaxCoveredTiles)
    by_zoom_[static_cast<std::size_t>(tile.z())].push_back(PlaceInZoom(tile));
}

void TileJudge::LookAt(const geo::TileId& tile, std::string_view picture) {
  const std::string name = NameOf(tile);
  if (picture.empty()) return counted_.Add(Severity::kError, "tiles are empty", name);
  const auto format = image::PictureFormatOf(picture);
  if (!format) return counted_.Add(Severity::kError, "tiles are no PNG, JPEG or WebP picture", name);
  ++of_format_[static_cast<std::size_t>(*format)];
  if (pictures_++ % decodes_one_in_ != 0) return;
  const auto decoded = image::DecodePicture(picture);
  if (!decoded) return counted_.Add(Severity::kError, "tiles are damaged pictures", name);
  if (decoded->width_px != decoded->height_px)
    return counted_.Add(Severity::kError, "tiles are not square",
                        fmt::format("{} of {} x {}", name, decoded->width_px, decoded->height_px));
  if (side_px_ == 0) side_px_ = decoded->width_px;
  if (decoded->width_px != side_px_)
    counted_.Add(Severity::kError, "tiles are of another size than the first",
                 fmt::format("{} of {} pixels", name, decoded->width_px));
}

void TileJudge::JudgePictures(const TilesetClaims& claims, FileVerdict& verdict) const {
  const std::int64_t all = std::accumulate(of_format_.begin(), of_format_.end(), std::int64_t{0});
  if (all == 0) return;
  if (!claims.format.empty()) {
    const auto format = image::PictureFormatNamed(claims.format).value_or(image::PictureFormat::kJpeg);
    const std::int64_t said = of_format_[static_cast<std::size_t>(format)];
    if (said == 0) {
      verdict.Add(Severity::kError, fmt::format("it says that its tiles are {}, and none is", claims.format));
    } else if (said < all) {
      verdict.Add(Severity::kNote,
                  fmt::format("{} of {} tiles are not {}; the edge of a map often has a format of its own",
                              all - said, all, claims.format));
    }
  }
  if (side_px_ > 0 && !std::has_single_bit(static_cast<unsigned>(side_px_)))
    verdict.Add(Severity::kWarning,
                fmt::format("its tiles have {} pixels a side; most programs know 256 and 512", side_px_));
  if (claims.tile_size_px && side_px_ > 0 && *claims.tile_size_px != side_px_)
    verdict.Add(Severity::kError,
                fmt::format("it says that its tiles have {} pixels a side, and they have {}",
                            *claims.tile_size_px, side_px_));
}

int TileJudge::MinZoom() const {
  int zoom = 0;
  while (zoom <= geo::kMaxZoom && by_zoom_[static_cast<std::size_t>(zoom)].empty()) ++zoom;
  return zoom;
}

int TileJudge::MaxZoom() const {
  int zoom = geo::kMaxZoom;
  while (zoom >= 0 && by_zoom_[static_cast<std::size_t>(zoom)].empty()) --zoom;
  return zoom;
}

void TileJudge::JudgeZooms(const TilesetClaims& claims, FileVerdict& verdict) const {
  const auto compare = [&](const char* name, std::optional<int> said, int is) {
    if (!said || *said == is) return;
    verdict.Add(Severity::kError,
                fmt::format("{} is {}, and the tiles have {}: clients ask for others than there are", name,
                            *said, is));
  };
  compare("minzoom", claims.min_zoom, MinZoom());
  compare("maxzoom", claims.max_zoom, MaxZoom());
  for (int zoom = MinZoom(); zoom <= MaxZoom(); ++zoom) {
    if (by_zoom_[static_cast<std::size_t>(zoom)].empty())
      verdict.Add(Severity::kError, fmt::format("zoom {} has no tiles, and finer ones have", zoom));
  }
}

void TileJudge::JudgeParents(FileVerdict& verdict) {
  if (static_cast<std::size_t>(tiles_) > kMaxCoveredTiles) {
    verdict.Add(Severity::kNote, "it has too many tiles to see whether each is seen from afar");
    return;
  }
  CountedFindings holes;
  for (int zoom = 0; zoom <= geo::kMaxZoom; ++zoom) {
    std::vector<std::uint64_t>& tiles = by_zoom_[static_cast<std::size_t>(zoom)];
    std::sort(tiles.begin(), tiles.end());
    const auto twice = std::adjacent_find(tiles.begin(), tiles.end());
    if (twice != tiles.end())
      verdict.Add(Severity::kError,
                  fmt::format("tile {}/{}/{} is there twice", zoom, *twice >> 32, *twice & 0xFFFFFFFFu));
    if (zoom <= MinZoom()) continue;
    const std::vector<std::uint64_t>& coarser = by_zoom_[static_cast<std::size_t>(zoom - 1)];
    if (coarser.empty()) continue;
    for (const std::uint64_t tile : tiles) {
      const std::uint64_t x = tile >> 32, y = tile & 0xFFFFFFFFu;
      if (!std::binary_search(coarser.begin(), coarser.end(), x >> 1 << 32 | y >> 1))
        holes.Add(Severity::kWarning, "tiles are missing from the zoom above: they vanish from afar",
                  fmt::format("{}/{}/{}", zoom, x, y));
    }
  }
  holes.MoveTo(verdict);
}

void TileJudge::JudgeBounds(const TilesetClaims& claims, FileVerdict& verdict) const {
  if (!claims.bounds || tiles_ == 0) return;
  geo::LatLonBounds said = *claims.bounds;
  if (!AreBounds(said)) {
    verdict.Add(Severity::kError,
                "bounds " + TextOfBounds(said) + " are none; they are west,south,east,north in degrees");
    return;
  }
  const bool is_world = said.east_deg - said.west_deg >= 359.9;
  said.south_deg = std::max(said.south_deg, -kLastLatDeg);
  said.north_deg = std::min(said.north_deg, kLastLatDeg);
  const geo::Bounds2 told = geo::MercFromLatLonBounds(said);
  geo::Bounds2 covered;
  for (const std::uint64_t place : by_zoom_[static_cast<std::size_t>(MaxZoom())]) {
    const geo::Bounds2 tile = geo::TileId::Make(MaxZoom(), static_cast<std::int64_t>(place >> 32),
                                                static_cast<std::int64_t>(place & 0xFFFFFFFFu))
                                  ->BoundsInMerc();
    // Those of a map across the antimeridian lie at both ends of the web map's square.
    constexpr double kWorldM = 2.0 * geo::kMercHalfWidthM;
    const double off_m = 0.5 * (told.min.x() + told.max.x() - tile.min.x() - tile.max.x());
    const Eigen::Vector2d turn_m(kWorldM * std::round(off_m / kWorldM), 0.0);
    covered.Include(geo::Bounds2{tile.min + turn_m, tile.max + turn_m});
  }
  const std::string where = TextOfBounds(geo::LatLonBoundsFromMerc(covered).OnEarth());
  const double tile_m = geo::TileSizeInMercM(MaxZoom()), slack_m = 1.01 * tile_m;
  const bool are_apart = told.min.x() >= covered.max.x() || told.max.x() <= covered.min.x() ||
                         told.min.y() >= covered.max.y() || told.max.y() <= covered.min.y();
  const bool stick_out = ((told.min - covered.min).array() > slack_m).any() ||
                         ((covered.max - told.max).array() > slack_m).any();
  const bool are_larger = ((covered.min - told.min).array() > slack_m).any() ||
                          ((told.max - covered.max).array() > slack_m).any();
  if (are_apart) {
    verdict.Add(Severity::kError,
                fmt::format("bounds say {}, and the tiles lie at {}", TextOfBounds(said), where));
  } else if (stick_out) {
    verdict.Add(
        Severity::kError,
        fmt::format("tiles lie beyond the bounds, where clients do not ask for them: bounds {}, tiles {}",
                    TextOfBounds(said), where));
  } else if (are_larger) {
    verdict.Add(
        is_world ? Severity::kNote : Severity::kWarning,
        fmt::format("bounds {} are larger than the tiles, which lie at {}", TextOfBounds(said), where));
  }
}

void TileJudge::Finish(const TilesetClaims& claims, FileVerdict& verdict) {
  verdict.tiles = tiles_;
  verdict.tile_size_px = side_px_;
  verdict.bounds = claims.bounds;
  if (tiles_ == 0) {
    verdict.Add(Severity::kError, "it has no tiles");
  } else {
    verdict.min_zoom = MinZoom();
    verdict.max_zoom = MaxZoom();
  }
  counted_.MoveTo(verdict);
  JudgePictures(claims, verdict);
  if (tiles_ == 0) return;
  JudgeZooms(claims, verdict);
  JudgeParents(verdict);
  JudgeBounds(claims, verdict);
}

}  // namespace skyquilt::storage
