#include "storage/catalogue/previews.h"

#include <xxhash.h>

#include <utility>

#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::storage {
Result<std::optional<PreviewWork>> Previews::Claim(int limit) {
  return db_.Again([&]() -> Result<std::optional<PreviewWork>> {
    const auto db = db_.Lock();
    // Whoever finds nothing only reads.
    SKYQUILT_TRY_ASSIGN(const bool is_any,
                        db->Finds("SELECT 1 FROM file f JOIN flight t ON t.id=f.flight_id"
                                  " WHERE f.preview_state=0 AND t.deleted_us IS NULL LIMIT 1"));
    if (!is_any) return std::optional<PreviewWork>();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
    SKYQUILT_TRY(
        db->Exec("UPDATE file SET preview_state=2 WHERE preview_state=0"
                 " AND flight_id IN (SELECT id FROM flight WHERE active_revision IS NOT NULL)"));
    SKYQUILT_TRY_ASSIGN(
        std::optional<PreviewWork> work,
        db->First(
            [](const Statement& row) {
              return PreviewWork{row.Get<std::string>(0), {}, {}};
            },
            "SELECT f.flight_id FROM file f JOIN flight t ON t.id=f.flight_id"
            " LEFT JOIN preview p ON p.flight_id=f.flight_id WHERE f.preview_state=0 AND t.deleted_us IS NULL"
            " ORDER BY coalesce(p.photos,0), f.created_us LIMIT 1"));
    if (work) {
      constexpr const char* kFiles =
          "SELECT name, stored_name, bytes FROM file WHERE flight_id=? AND preview_state=";
      SKYQUILT_TRY_ASSIGN(work->tried, db->All(FileFrom, std::string(kFiles) + "1 ORDER BY created_us, name",
                                               work->flight_id));
      SKYQUILT_TRY_ASSIGN(work->fresh,
                          db->All(FileFrom, std::string(kFiles) + "0 ORDER BY created_us, name LIMIT ?",
                                  work->flight_id, limit));
      SKYQUILT_TRY_ASSIGN(Statement mark, db->Prepare("UPDATE file SET preview_state=1 WHERE stored_name=?"));
      for (const StoredFile& file : work->fresh) {
        SKYQUILT_TRY(mark.Bind(1, file.stored_name).Run());
      }
    }
    SKYQUILT_TRY(transaction.Commit());
    return work;
  });
}

Result<std::optional<Preview>> Previews::Find(const std::string& flight_id) const {
  const auto db = db_.Read();
  const auto preview_from = [](const Statement& row) {
    Preview preview;
    geo::LatLonBounds &bounds = preview.bounds, &changed = preview.changed;
    row.Into(preview.flight_id, preview.folder, preview.edition, preview.photos, preview.min_zoom,
             preview.max_zoom, bounds.west_deg, bounds.south_deg, bounds.east_deg, bounds.north_deg,
             changed.west_deg, changed.south_deg, changed.east_deg, changed.north_deg);
    return preview;
  };
  return db->First(preview_from,
                   "SELECT flight_id, folder, edition, photos, min_zoom, max_zoom, west, south, east, north,"
                   " changed_west, changed_south, changed_east, changed_north FROM preview WHERE flight_id=?",
                   flight_id);
}

Result<void> Previews::Forgo(const std::vector<StoredFile>& files) { return Mark(files, 2); }
Result<void> Previews::GiveBack(const std::vector<StoredFile>& files) { return Mark(files, 0); }

Result<void> Previews::Mark(const std::vector<StoredFile>& files, int state) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  {
    SKYQUILT_TRY_ASSIGN(Statement mark, db->Prepare("UPDATE file SET preview_state=? WHERE stored_name=?"));
    for (const StoredFile& file : files) {
      SKYQUILT_TRY(mark.BindAll(state, file.stored_name).Run());
    }
  }
  return transaction.Commit();
}

Result<bool> Previews::Show(const Preview& preview) {
  const auto db = db_.Lock();
  // A first edition begins a preview; a later one goes on with the very same, or comes to nothing.
  const geo::LatLonBounds &bounds = preview.bounds, &changed = preview.changed;
  SKYQUILT_TRY(db->Change(
      preview.edition == 1
          ? "INSERT INTO preview SELECT ?1,?2,?3,?4,?5,?6,?7,?8,?9,?10,?11,?12,?13,?14 FROM flight"
            " WHERE id=?1 AND active_revision IS NULL AND deleted_us IS NULL ON CONFLICT DO NOTHING"
          : "UPDATE preview SET edition=?3, photos=?4, min_zoom=?5, max_zoom=?6, west=?7, south=?8, east=?9,"
            " north=?10, changed_west=?11, changed_south=?12, changed_east=?13, changed_north=?14"
            " WHERE flight_id=?1 AND folder=?2",
      preview.flight_id, preview.folder, preview.edition, preview.photos, preview.min_zoom, preview.max_zoom,
      bounds.west_deg, bounds.south_deg, bounds.east_deg, bounds.north_deg, changed.west_deg,
      changed.south_deg, changed.east_deg, changed.north_deg));
  return db->Changes() > 0;
}

std::string NewPreviewFolder() { return kPreviewFolderPrefix + NewId(); }

namespace {

constexpr const char* kFileName = "tiles.db";

}  // namespace

Result<std::shared_ptr<PreviewTiles>> PreviewTiles::Open(const std::filesystem::path& folder) {
  SKYQUILT_TRY_ASSIGN(SqliteDb db, SqliteDb::Open(folder / kFileName, OpenMode::kReadWriteCreate));
  SKYQUILT_TRY(db.Exec(
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;"
      "CREATE TABLE IF NOT EXISTS tile(zoom INTEGER, x INTEGER, y INTEGER, bytes BLOB, UNIQUE(zoom, x, y))"));
  return std::shared_ptr<PreviewTiles>(new PreviewTiles(std::move(db)));
}

Result<std::shared_ptr<PreviewTiles>> PreviewTiles::OpenToRead(const std::filesystem::path& folder) {
  std::error_code missing;
  if (!std::filesystem::exists(folder / kFileName, missing)) {
    return Error{ErrorCode::kNotFound, "The preview has ended.", folder.string()};
  }
  return Open(folder);
}

Result<std::optional<FoundTile>> PreviewTiles::Find(const geo::TileId& tile) {
  const std::lock_guard lock(mutex_);
  SKYQUILT_TRY_ASSIGN(Statement query, db_.Query("SELECT bytes FROM tile WHERE zoom=? AND x=? AND y=?",
                                                 tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.y()}));
  return query.First([](const Statement& row) {
    const auto blob = row.ColumnBlob(0);
    return FoundTile{XXH3_64bits(blob.data(), blob.size()),
                     std::string(reinterpret_cast<const char*>(blob.data()), blob.size())};
  });
}

Result<void> PreviewTiles::Put(const Tiles& tiles) {
  const std::lock_guard lock(mutex_);
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(db_));
  {
    SKYQUILT_TRY_ASSIGN(Statement write, db_.Prepare("INSERT OR REPLACE INTO tile VALUES(?,?,?,?)"));
    for (const auto& [tile, bytes] : tiles) {
      const std::span blob(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
      SKYQUILT_TRY(write.BindAll(tile.z(), std::int64_t{tile.x()}, std::int64_t{tile.y()}, blob).Run());
    }
  }
  return transaction.Commit();
}

Result<std::shared_ptr<const OpenPreview>> PreviewCache::Get(const std::string& flight_id) {
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(flight_id);
  if (found != entries_.end() && now - found->second.checked < kFreshFor) return found->second.open;
  SKYQUILT_TRY_ASSIGN(const std::optional<Preview> preview, previews_.Find(flight_id));
  if (!preview) {
    entries_.erase(flight_id);
    return Error{ErrorCode::kNotFound, "This flight has no preview.", ""};
  }
  std::shared_ptr<PreviewTiles> tiles;
  if (found != entries_.end() && found->second.open->preview.folder == preview->folder) {
    tiles = found->second.open->tiles;
  } else {
    SKYQUILT_TRY_ASSIGN(tiles, PreviewTiles::OpenToRead(dir_.Flight(flight_id) / preview->folder));
  }
  // The old ones are mostly of flights that have their maps: none is worth keeping.
  if (entries_.size() >= kMaxOpen) entries_.clear();
  auto open = std::make_shared<const OpenPreview>(OpenPreview{*preview, std::move(tiles)});
  entries_[flight_id] = {open, now};
  return open;
}

}  // namespace skyquilt::storage
