// MBTiles specification 1.3, chapters "Database specifications", "Metadata" and "Tiles".
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <system_error>

#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/image/picture_format.h"
#include "storage/db/sqlite_db.h"
#include "storage/tilesets/tile_source.h"
#include "storage/validation/tile_judge.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;
using Claims = TilesetFacts;

constexpr int kMaxIntegrityLines = 5;

// False: it is so damaged that nothing else can be said.
bool CheckIntegrity(SqliteDb& db, bool quick, FileVerdict& verdict) {
  auto check = db.Prepare(quick ? "PRAGMA quick_check(5)" : "PRAGMA integrity_check(5)");
  if (!check) {
    verdict.Add(Severity::kError, "it is no SQLite database, or one that is damaged or cut off");
    return false;
  }
  for (int lines = 0; lines < kMaxIntegrityLines; ++lines) {
    const Result<bool> more = check->Step();
    if (!more) {
      verdict.Add(Severity::kError, "the database is damaged: " + more.error().detail);
      return false;
    }
    if (!*more) break;
    const std::string said(check->ColumnText(0));
    if (said != "ok") verdict.Add(Severity::kError, "the database is damaged: " + said);
  }
  return true;
}

Claims ReadClaims(SqliteDb& db, FileVerdict& verdict) {
  Claims claims;
  auto rows = db.Prepare("SELECT name, value FROM metadata");
  if (!rows) {
    verdict.Add(Severity::kError, "it has no table \"metadata\" with the columns name and value");
    return claims;
  }
  while (true) {
    const Result<bool> more = rows->Step();
    if (!more) verdict.Add(Severity::kError, "its metadata cannot be read: " + more.error().detail);
    if (!more || !*more) break;
    const std::string name(rows->ColumnText(0));
    if (!claims.emplace(name, std::string(rows->ColumnText(1))).second)
      verdict.Add(Severity::kError, "metadata has \"" + name + "\" twice");
  }
  return claims;
}

std::optional<int> ZoomOf(const Claims& claims, const char* name, FileVerdict& verdict) {
  const auto found = claims.find(name);
  if (found == claims.end()) {
    verdict.Add(Severity::kWarning, fmt::format("metadata has no {}; clients must guess it", name));
    return std::nullopt;
  }
  const std::optional<int> zoom = ParseNumber<int>(found->second);
  if (zoom && *zoom >= 0 && *zoom <= geo::kMaxZoom) return zoom;
  verdict.Add(Severity::kError, fmt::format("{} is \"{}\", which is no zoom", name, found->second));
  return std::nullopt;
}

// Exactly so many numbers between commas.
std::optional<std::vector<double>> NumbersOf(const std::string& text, std::size_t count) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double value = 0.0; numbers.size() <= count && in >> value;) {
    numbers.push_back(value);
    char comma = 0;
    if (in >> comma && comma != ',') return std::nullopt;
  }
  if (!in.eof() || numbers.size() != count) return std::nullopt;
  return numbers;
}

TilesetClaims JudgeClaims(const Claims& claims, FileVerdict& verdict) {
  TilesetClaims told;
  const auto value = [&](const char* name) { return TilesetText(claims, name); };
  if (value("name").empty()) verdict.Add(Severity::kError, "metadata has no name, which MBTiles demands");
  const std::string format = value("format");
  if (format.empty()) verdict.Add(Severity::kError, "metadata has no format, which MBTiles demands");
  const std::optional<image::PictureFormat> known = image::PictureFormatNamed(format);
  if (known && format == image::ExtensionOf(*known)) told.format = format;
  if (format == "jpeg") verdict.Add(Severity::kError, "format is \"jpeg\"; MBTiles has it as \"jpg\"");
  if (format == "pbf" && value("json").empty())
    verdict.Add(Severity::kError, "metadata has no json, which MBTiles demands of vector tiles");
  told.min_zoom = ZoomOf(claims, "minzoom", verdict);
  told.max_zoom = ZoomOf(claims, "maxzoom", verdict);
  if (const std::string bounds = value("bounds"); bounds.empty()) {
    verdict.Add(Severity::kWarning, "metadata has no bounds; clients show the whole world");
  } else if (const auto box = NumbersOf(bounds, 4)) {
    told.bounds = geo::LatLonBounds{(*box)[0], (*box)[1], (*box)[2], (*box)[3]};
  } else {
    verdict.Add(Severity::kError, "bounds are \"" + bounds + "\"; they are west,south,east,north in degrees");
  }
  if (const std::string centre = value("center"); !centre.empty() && !NumbersOf(centre, 3))
    verdict.Add(Severity::kError, "center is \"" + centre + "\"; it is longitude,latitude,zoom");
  if (const std::string type = value("type"); !type.empty() && type != "overlay" && type != "baselayer")
    verdict.Add(Severity::kWarning, "type is \"" + type + "\"; MBTiles has overlay and baselayer");
  if (const auto size = NumbersOf(value("tile_size"), 1)) told.tile_size_px = static_cast<int>(size->front());
  if (value("scheme") == "xyz")
    verdict.Add(Severity::kError, "rows count from the north (scheme \"xyz\"); MBTiles count from the south");
  return told;
}

// Rows that lead to pictures which are not there: a view leaves them out without a word.
void JudgeLostPictures(SqliteDb& db, FileVerdict& verdict) {
  for (const auto& [rows, pictures, id] :
       {std::array{"tiles_shallow", "tiles_data", "tile_data_id"}, std::array{"map", "images", "tile_id"}}) {
    const Result<std::int64_t> count = db.Number(
        fmt::format("SELECT count(*) FROM {0} WHERE {2} NOT IN (SELECT {2} FROM {1})", rows, pictures, id));
    if (count && *count > 0)
      verdict.Add(Severity::kError,
                  fmt::format("{} tiles lead to pictures that are not there (table {})", *count, pictures));
  }
}

Result<void> WalkTiles(SqliteDb& db, bool are_pictures, TileJudge& judge, FileVerdict& verdict,
                       Progress& progress) {
  auto count = db.Prepare("SELECT count(*) FROM tiles");
  auto rows = db.Prepare("SELECT zoom_level, tile_column, tile_row, typeof(tile_data), tile_data FROM tiles");
  if (!count || !rows) {
    verdict.Add(Severity::kError,
                "it has no table \"tiles\" with the columns zoom_level, tile_column, tile_row and tile_data");
    return {};
  }
  const Result<bool> counted = count->Step();
  const auto all = counted && *counted ? static_cast<double>(count->ColumnInt64(0)) : 1.0;
  for (double done = 1.0;; done += 1.0) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled.", ""};
    const Result<bool> more = rows->Step();
    if (!more) verdict.Add(Severity::kError, "its tiles cannot be read to the end: " + more.error().detail);
    if (!more || !*more) return {};
    const std::int64_t z = rows->ColumnInt64(0), x = rows->ColumnInt64(1), row = rows->ColumnInt64(2);
    const auto side = std::int64_t{1} << std::clamp<std::int64_t>(z, 0, geo::kMaxZoom);
    const auto tile = geo::TileId::Make(z, x, row >= 0 && row < side ? side - 1 - row : -1);
    if (!tile) {
      judge.counted().Add(Severity::kError, "tiles lie nowhere: their column or row is outside their zoom",
                          fmt::format("zoom {} column {} row {}", z, x, row));
      continue;
    }
    judge.Cover(*tile);
    const auto blob = rows->ColumnBlob(4);
    const std::string_view bytes(reinterpret_cast<const char*>(blob.data()), blob.size());
    if (rows->ColumnText(3) != "blob") {
      judge.counted().Add(Severity::kError, "tiles are not stored as a blob", TileJudge::NameOf(*tile));
    } else if (are_pictures) {
      judge.LookAt(*tile, bytes);
    }
    progress.Report(done / std::max(all, 1.0), "looking at tiles");
  }
}

}  // namespace

Result<FileVerdict> ValidateMbtiles(const fs::path& path, bool quick, Progress& progress) {
  FileVerdict verdict;
  verdict.file = path.filename().string();
  verdict.kind = "MBTiles";
  std::error_code gone;
  if (const auto wal = fs::file_size(path.string() + "-wal", gone); !gone && wal > 0)
    verdict.Add(Severity::kWarning, verdict.file +
                                        "-wal lies beside it: a program still writes to it, or did "
                                        "not close it; what is in there is not looked at");
  if (fs::exists(path.string() + "-journal", gone))
    verdict.Add(Severity::kWarning, verdict.file +
                                        "-journal lies beside it: a program was writing to it and "
                                        "did not end");
  auto db = SqliteDb::Open(path, OpenMode::kReadOnlyImmutable);
  if (!db) {
    verdict.Add(Severity::kError, "it is no SQLite database, or one that is damaged or cut off");
    return verdict;
  }
  if (!CheckIntegrity(*db, quick, verdict)) return verdict;
  const Claims claims = ReadClaims(*db, verdict);
  const TilesetClaims told = JudgeClaims(claims, verdict);
  const auto format = claims.find("format");
  const bool are_pictures =
      format == claims.end() || format->second.empty() || !told.format.empty() || format->second == "jpeg";
  if (!are_pictures)
    verdict.Add(Severity::kNote,
                "its tiles are \"" + format->second + "\"; what is in them is not looked at");
  JudgeLostPictures(*db, verdict);
  TileJudge judge(quick);
  SKYQUILT_TRY(WalkTiles(*db, are_pictures, judge, verdict, progress));
  judge.Finish(told, verdict);
  return verdict;
}

}  // namespace skyquilt::storage
