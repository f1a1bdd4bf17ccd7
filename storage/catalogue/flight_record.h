// FlightRecords: beside each flight's files a record of its own, flight.jsonl, from which the catalogue can
// be made anew: the flight's name, options, owner, time and tags, and under which name the user sent each
// stored file. One line of JSON per change, only ever appended and fsynced before the change is said to be
// done, so that a record is whole up to its last line whatever happens. Lines:
//   {"flight": {"name": ..., "options": ..., "owner": ..., "created_us": ..., "tags": [...], "keep": ...,
//   "trashed_us": ... or null}} (any of them)
//   {"file": {"stored": ..., "name": ..., "bytes": ..., "created_us": ...}}
//   {"removed": "<stored name>"}
//   {"deleting": <time>}, then {"deleted": <time>}; any "flight" line later takes "deleting" back
// Writing: one thread at a time for a flight (the catalogue's lock). Errors: kNotFound (the flight's folder
// is gone), kOutOfSpace, kUnavailable (the data folder is gone), kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

inline constexpr const char* kFlightRecordName = "flight.jsonl";

struct RecordedFile {
  std::string name;  // the user's
  std::int64_t bytes = 0;
  Time created;
  bool is_removed = false;  // by the user
  // The stored name of the next file of this name, which took its place if its bytes are there: a process
  // that died between the two had no time to say that this one is removed.
  std::string replaced_by = {};
};

struct FlightRecord {
  std::optional<std::string> name, options, owner;
  std::optional<Time> created;
  std::optional<std::vector<std::string>> tags;  // storage/tags/flight_tags.h
  std::optional<bool> is_kept;                   // it never goes to the trash by itself
  std::optional<Time> trashed;                   // the user put the flight into the trash, where it still is
  bool is_deleting = false;                      // the catalogue was about to forget it
  bool is_deleted = false;                       // and did
  bool is_whole = false;  // names every file that was ever accepted: no line is missing or damaged
  std::map<std::string, RecordedFile> files;  // by stored name
};

// Takes any bytes: what is no line of a record is passed over and costs `is_whole`. The last line may be
// torn.
FlightRecord ParseFlightRecord(std::string_view text);

// Of the flight in a folder; absent where it has none. Errors: kIo.
Result<std::optional<FlightRecord>> ReadFlightRecord(const std::filesystem::path& flight_folder);

class FlightRecords {
 public:
  explicit FlightRecords(DataDir dir) : dir_(std::move(dir)) {}

  const DataDir& dir() const { return dir_; }
  bool Has(const std::string& flight_id) const;
  // Photos and maps lie elsewhere: a start knows by the records alone what a catalogue lacks.
  bool AreAllThatIsHere() const;
  // Makes the flight's folder with its record in it, or writes the whole record anew.
  Result<void> Begin(const std::string& flight_id, const FlightRecord& record) const;
  // What is set in `change` of name, options, owner, created, tags and is_kept.
  Result<void> Change(const std::string& flight_id, const FlightRecord& change) const;
  Result<void> SetTrashed(const std::string& flight_id, std::optional<Time> trashed) const;
  Result<void> AddFile(const std::string& flight_id, const std::string& stored_name,
                       const RecordedFile& file) const;
  Result<void> RemoveFile(const std::string& flight_id, const std::string& stored_name) const;
  Result<void> Deleting(const std::string& flight_id, Time now) const;
  Result<void> Deleted(const std::string& flight_id, Time now) const;
  // The folder of a flight that came to nothing, where the record is all that is in it.
  void Undo(const std::string& flight_id) const;

 private:
  Result<void> Append(const std::string& flight_id, const std::string& line) const;
  DataDir dir_;
};

}  // namespace skyquilt::storage
