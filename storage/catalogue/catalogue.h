// Catalogue: which flights there are, which files belong to them, and which finished revision is shown.
// Values in, values out; the files themselves are in PhotoStore. A flight in the trash
// (storage/catalogue/trash.h) does not exist for these functions unless they say otherwise. Any thread.
// Errors: kNotFound (no such flight or file), kConflict (a job is using it), kOutOfSpace, kUnavailable, kIo.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/catalogue/flight_record.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct Flight {
  std::string id;
  std::string name;
  std::string options;  // JSON text
  Time created;
  std::int64_t file_count = 0;
  std::int64_t bytes = 0;
  std::optional<std::int64_t> active_revision;
  std::string owner = {};              // id of the token that made it; empty without one
  std::vector<std::string> tags = {};  // storage/tags/flight_tags.h
  bool is_kept = false;                // it never goes to the trash by itself
};

struct StoredFile {
  std::string name;         // the user's
  std::string stored_name;  // ours, below flights/<id>/files
  std::int64_t bytes = 0;
};
// Of a row of name, stored name and bytes.
StoredFile FileFrom(const Statement& row);

// What a finished map says of itself.
struct Revision {
  std::int64_t revision = 0;
  Time created;
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  double gsd_m = 0.0;
  int photos_total = 0;
  int photos_aligned = 0;
  int photos_pose_only = 0;
  int photos_left_out = 0;
  // When its photos were taken: ISO 8601 by the clock on the wall there (core/pipeline/report/mosaic_report);
  // empty where that is not known.
  std::string first_capture, last_capture;
  std::string quality;  // JSON (core/pipeline/report/map_quality.h); empty where it is not known
};

// Enters a finished map and shows it in place of the preview. Within the caller's transaction.
Result<void> ShowRevision(SqlConnection& db, const std::string& flight_id, const Revision& revision,
                          Time created);

struct FlightPage {
  std::vector<Flight> flights;  // newest first
  std::optional<std::string> next_cursor;
};

// A flight that shows a finished map.
struct ShownFlight {
  std::string flight_id;
  std::string name;
  Revision revision;
  std::vector<std::string> tags = {};
};

// What is to become of a flight; the rest stays as it is.
struct FlightChange {
  std::optional<std::string> name = {}, options = {};
  std::optional<std::vector<std::string>> tags = {};  // checked (storage/tags/flight_tags.h)
  std::optional<bool> is_kept = {};

  bool IsAny() const { return name || options || tags || is_kept; }
};

struct MapPage {
  std::vector<ShownFlight> maps;  // of the newest flights first
  std::optional<std::string> next_cursor;
};

struct AddedFile {
  bool replaced = false;
  std::string replaced_stored_name;  // the caller removes this file now
  std::int64_t replaced_bytes = 0;
};

// kNotFound, in the words that clients see.
Error NoSuchFlight(const std::string& id);
// That there is one, and not in the trash.
Result<void> RequireFlight(SqlConnection& db, const std::string& id);

class Catalogue {
 public:
  // `records`: where each change of a flight or its files is written down beside them as well, so that a
  // catalogue that is lost can be made anew. Absent: nowhere (for whoever only reads, and tests).
  explicit Catalogue(CatalogueDb& db, std::optional<FlightRecords> records = std::nullopt)
      : db_(db), records_(std::move(records)) {}

  // `owner`: id of a token; empty where nobody showed one.
  // `marks`: its tags and whether it is kept.
  Result<Flight> AddFlight(const std::string& name, const std::string& options, Time now,
                           const std::string& owner = "", const FlightChange& marks = {});
  // What the flights of an owner hold, with the uploads that are still coming.
  Result<std::int64_t> BytesOf(const std::string& owner) const;
  Result<std::string> OwnerOf(const std::string& flight_id) const;
  Result<Flight> GetFlight(const std::string& id) const;
  // Flights older than `cursor` (an id that an earlier page ended with), or the newest; of these, with `tag`,
  // those that have it.
  Result<FlightPage> ListFlights(int limit, const std::optional<std::string>& cursor,
                                 const std::optional<std::string>& tag = std::nullopt) const;
  // The same of the flights that show a map, each with it.
  Result<MapPage> ListMaps(int limit, const std::optional<std::string>& cursor) const;
  // All of it or nothing.
  Result<void> ChangeFlight(const std::string& id, const FlightChange& change);
  // For good, also from the trash. Files, revisions and jobs go with it; a worker that runs one of its jobs
  // loses its lease. With `trashed_until` one alone that went to the trash by then (AgeClock) and is there
  // still: kNotFound else.
  Result<void> DeleteFlight(const std::string& id, std::optional<Time> trashed_until = std::nullopt);
  Result<bool> HasFlight(const std::string& id) const;
  // With those in the trash: all whose files are to stay on the disk.
  Result<std::vector<std::string>> FlightIds() const;

  // Takes the place of a file of the same name; kConflict while a job reads the flight's files.
  // With `expected`, the stored name of what it replaces (empty: nothing): kPreconditionFailed where another
  // is there.
  Result<AddedFile> AddFile(const std::string& flight_id, const StoredFile& file, Time now,
                            const std::optional<std::string>& expected = std::nullopt);
  // Never replaces: picks "a(2).jpg" for a second "a.jpg" and says so in the answer's name. With
  // `upload_id`, that resumable upload is done in the same transaction.
  Result<StoredFile> AddFileUnderFreeName(const std::string& flight_id, const StoredFile& file, Time now,
                                          const std::optional<std::string>& upload_id = std::nullopt);
  // kConflict while a job reads the flight's files. `expected`: as above, the stored name of what is to go.
  Result<StoredFile> RemoveFile(const std::string& flight_id, const std::string& name,
                                const std::optional<std::string>& expected = std::nullopt);
  Result<std::optional<StoredFile>> FindFile(const std::string& flight_id, const std::string& name) const;
  // Also of a flight in the trash, whose files are kept.
  Result<std::vector<StoredFile>> ListFiles(const std::string& flight_id) const;

  // All that a record has of a flight.
  Result<FlightRecord> RecordOf(const std::string& flight_id) const;

  Result<std::optional<Revision>> ActiveRevision(const std::string& flight_id) const;
  // Also of a flight in the trash.
  Result<std::vector<std::int64_t>> Revisions(const std::string& flight_id) const;
  // The number of its next map: none has been given out from there on.
  Result<std::int64_t> NextRevision(const std::string& flight_id) const;

 private:
  // Before the commit: a file that the catalogue knows is in the record.
  Result<void> Record(const std::string& flight_id, const StoredFile& file, Time now) const;
  // After a commit that failed, for `why`: the record says what the catalogue has. Well: the file is there,
  // and only the answer was lost.
  Result<void> SettleRecord(SqlConnection& db, const std::string& flight_id, const StoredFile& file,
                            const Error& why) const;

  CatalogueDb& db_;
  std::optional<FlightRecords> records_;
};

}  // namespace skyquilt::storage
