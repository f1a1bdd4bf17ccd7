#include <fmt/core.h>

#include <bit>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "server/imports/imported_tileset.h"
#include "storage/exports/custom/export_request.h"
#include "storage/exports/stored_tiles.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::server {
namespace {

constexpr std::int64_t kMaxImportedTiles = 4'000'000;
constexpr int kMinSidePx = 64, kMaxSidePx = 1024;
constexpr std::size_t kMaxAttributionBytes = 4096;

// What is wrong with a file, as a person names it.
class Refusals {
 public:
  using Values = std::map<std::string, flight::RemarkValue>;
  explicit Refusals(std::string file) : file_(std::move(file)) {}
  Error Kind(flight::RemarkCode why, Values values = {}, const std::string& detail = "") const {
    return Made(ErrorCode::kUnsupportedFormat, why, std::move(values), detail);
  }
  Error Damaged(const std::string& detail) const {
    return Made(ErrorCode::kCorrupt, flight::RemarkCode::kImportDamaged, {}, detail);
  }
  Error Made(ErrorCode code, flight::RemarkCode why, Values values, const std::string& detail = "") const {
    values.emplace("file", file_);
    return flight::Because(code, {why, std::move(values)}, detail);
  }

 private:
  std::string file_;
};

using storage::TilesetFacts;
using storage::TilesetText;

Result<TilesetFacts> MetadataOf(storage::SqliteDb& db, const Refusals& refusals) {
  auto query = db.Prepare("SELECT name, value FROM metadata");
  if (!query) return refusals.Kind(flight::RemarkCode::kImportNoMbtiles);
  TilesetFacts metadata;
  while (true) {
    const Result<bool> row = query->Step();
    if (!row) return refusals.Damaged(row.error().detail);
    if (!*row) return metadata;
    metadata.emplace(query->ColumnText(0), query->ColumnText(1));
  }
}

Result<void> CheckMetadata(const TilesetFacts& metadata, const Refusals& refusals) {
  if (TilesetText(metadata, "format") == "pbf") return refusals.Kind(flight::RemarkCode::kImportVectorTiles);
  if (TilesetText(metadata, "scheme") == "xyz")
    return refusals.Kind(flight::RemarkCode::kImportRowsFromNorth);
  for (const char* key : {"crs", "srs"}) {
    const std::string crs = TilesetText(metadata, key);
    if (!crs.empty() && !crs.ends_with("3857") && !crs.ends_with("900913"))
      return refusals.Kind(flight::RemarkCode::kImportOtherSystem, {{"system", crs.substr(0, 40)}});
  }
  return {};
}

// What the finest zoom covers, and how much of it there is.
struct FinestTiles {
  std::int64_t count = 0;
  geo::Bounds2 merc;

  void Include(const geo::TileId& tile) {
    geo::Bounds2 bounds = tile.BoundsInMerc();
    // The other side of the antimeridian is next door.
    constexpr double kWorldM = 2.0 * geo::kMercHalfWidthM;
    const double apart_m = 0.5 * (merc.min.x() + merc.max.x() - bounds.min.x() - bounds.max.x());
    const bool is_beyond = count > 0 && std::abs(apart_m) > geo::kMercHalfWidthM;
    const double turn_m = is_beyond ? kWorldM * std::round(apart_m / kWorldM) : 0.0;
    bounds.min.x() += turn_m;
    bounds.max.x() += turn_m;
    merc = count++ == 0 ? bounds : geo::Bounds2{merc.min.cwiseMin(bounds.min), merc.max.cwiseMax(bounds.max)};
  }
};

class TileTaker {
 public:
  TileTaker(storage::MbtilesWriter& writer, const Refusals& refusals)
      : writer_(writer), refusals_(refusals) {}

  Result<void> Take(const geo::TileId& tile, std::string_view bytes) {
    const std::string name = fmt::format("{}/{}/{}", tile.z(), tile.x(), tile.y());
    if (bytes.size() > storage::kMaxTileBytes)
      return refusals_.Made(ErrorCode::kCorrupt, flight::RemarkCode::kImportTileDamaged, {{"tile", name}},
                            fmt::format("{} bytes", bytes.size()));
    const auto format = image::PictureFormatOf(bytes);
    if (!format) return refusals_.Kind(flight::RemarkCode::kImportTileNoPicture, {{"tile", name}});
    auto picture = image::DecodePicture(bytes);
    if (!picture)
      return refusals_.Made(ErrorCode::kCorrupt, flight::RemarkCode::kImportTileDamaged, {{"tile", name}},
                            picture.error().message);
    if (side_px_ == 0) {
      SKYQUILT_TRY(TakeSize(*picture));
    } else if (picture->width_px != side_px_ || picture->height_px != side_px_) {
      return refusals_.Kind(
          flight::RemarkCode::kImportTilesOfSeveralSizes,
          {{"tile", name}, {"width_px", picture->width_px}, {"height_px", picture->height_px}});
    }
    if (tile.z() != zoom_) finest_ = {};
    zoom_ = tile.z();
    min_zoom_ = tiles_++ == 0 ? zoom_ : min_zoom_;
    finest_.Include(tile);
    if (*format == image::PictureFormat::kJpeg && !image::IsYcbcrJpeg(bytes))
      return writer_.Put(tile, *format, image::EncodePicture(*std::move(picture), *format));
    return writer_.Put(tile, *format, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  }

  void Tell(pipeline::MosaicReport& report) const {
    report.bounds = geo::LatLonBoundsFromMerc(finest_.merc).OnEarth();
    report.min_zoom = min_zoom_;
    report.max_zoom = zoom_;
    report.tile_size_px = side_px_;
    report.tile_count = tiles_;
    const double ground = geo::GroundMetresPerMercMetre(report.bounds.Middle().lat_deg);
    const double tile_m = geo::TileSizeInMercM(zoom_) * ground;
    report.gsd_m = tile_m / side_px_;
    report.area_m2 = static_cast<double>(finest_.count) * tile_m * tile_m;
  }

 private:
  Result<void> TakeSize(const image::RgbaImage& picture) {
    const bool is_usual = picture.width_px == picture.height_px && picture.width_px >= kMinSidePx &&
                          picture.width_px <= kMaxSidePx &&
                          std::has_single_bit(static_cast<unsigned>(picture.width_px));
    if (!is_usual)
      return refusals_.Kind(flight::RemarkCode::kImportTilesOfOddSize,
                            {{"width_px", picture.width_px}, {"height_px", picture.height_px}});
    side_px_ = picture.width_px;
    return {};
  }

  storage::MbtilesWriter& writer_;
  const Refusals& refusals_;
  int side_px_ = 0;
  int zoom_ = -1, min_zoom_ = 0;
  std::int64_t tiles_ = 0;
  FinestTiles finest_;
};

// What the file says that it covers, where that fits its tiles.
void NarrowBounds(const TilesetFacts& metadata, geo::LatLonBounds& bounds) {
  const std::optional<geo::LatLonBounds> said = storage::TilesetBounds(metadata);
  if (!said) return;
  geo::LatLonBounds whole = *said;
  if (whole.east_deg < whole.west_deg) whole.east_deg += 360.0;  // as GeoJSON has it across the antimeridian
  if (whole.east_deg - whole.west_deg < 360.0) {
    whole = whole.Beside(bounds);
  } else {
    whole.west_deg = bounds.west_deg, whole.east_deg = bounds.east_deg;
  }
  const geo::LatLonBounds common = storage::Common(bounds, whole);
  if (common.west_deg < common.east_deg && common.south_deg < common.north_deg) bounds = common;
}

}  // namespace

Result<void> ImportTiles(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                         pipeline::MosaicReport& report, Progress& progress) {
  const Refusals refusals(file.name);
  auto db = storage::SqliteDb::Open(file.path, storage::OpenMode::kReadOnlyImmutable);
  if (!db && db.error().code != ErrorCode::kCorrupt) return db.error();
  if (!db) return refusals.Damaged(db.error().detail);
  SKYQUILT_TRY_ASSIGN(const TilesetFacts metadata, MetadataOf(*db, refusals));
  SKYQUILT_TRY(CheckMetadata(metadata, refusals));
  const Result<std::int64_t> count = storage::CountTiles(*db);
  if (!count) return refusals.Kind(flight::RemarkCode::kImportNoMbtiles, {}, count.error().detail);
  if (*count == 0) return refusals.Kind(flight::RemarkCode::kImportWithoutTiles);
  if (*count > kMaxImportedTiles)
    return refusals.Made(ErrorCode::kTooLarge, flight::RemarkCode::kImportManyTiles,
                         {{"tiles", *count}, {"most", kMaxImportedTiles}});
  SKYQUILT_TRY_ASSIGN(const auto writer, storage::MbtilesWriter::Create(mbtiles));
  TileTaker taker(*writer, refusals);
  auto walk = storage::TileWalk::Of(*db);
  if (!walk) return refusals.Damaged(walk.error().detail);
  for (std::int64_t done = 1;; ++done) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The import was cancelled."};
    const Result<bool> more = walk->Next();
    if (!more) return refusals.Damaged(more.error().detail + more.error().message);
    if (!*more) break;
    SKYQUILT_TRY(taker.Take(walk->tile(), walk->bytes()));
    progress.Report(static_cast<double>(done) / static_cast<double>(*count), "looking at tiles");
  }
  taker.Tell(report);
  NarrowBounds(metadata, report.bounds);
  return writer->Publish(
      MetadataOfImport(report, CutToBytes(TilesetText(metadata, "attribution"), kMaxAttributionBytes)));
}

}  // namespace skyquilt::server
