#include "storage/catalogue/flight_record.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::storage {
namespace {

using Json = nlohmann::json;

// Names come from clients and are checked, but a record must never be what fails.
std::string LineOf(const Json& json) { return JsonText(json) + "\n"; }

// For whoever sends photos: where the server keeps them is not theirs to know.
Error NotStored(const Error& error) {
  return {error.code,
          error.code == ErrorCode::kOutOfSpace ? "The server's disk is full. Free some space and try again."
                                               : "The server could not store the flight's record.",
          error.message};
}

Json FlightLine(const FlightRecord& record) {
  Json fields = Json::object();
  if (record.name) fields["name"] = *record.name;
  if (record.options) fields["options"] = *record.options;
  if (record.owner) fields["owner"] = *record.owner;
  if (record.created) fields["created_us"] = ToUs(*record.created);
  if (record.tags) fields["tags"] = *record.tags;
  if (record.is_kept) fields["keep"] = *record.is_kept;
  if (record.trashed) fields["trashed_us"] = ToUs(*record.trashed);
  return {{"flight", fields}};
}

Json FileLine(const std::string& stored_name, const RecordedFile& file) {
  return {{"file",
           {{"stored", stored_name},
            {"name", file.name},
            {"bytes", file.bytes},
            {"created_us", ToUs(file.created)}}}};
}

std::optional<std::int64_t> NumberOf(const Json& json, const char* key) {
  if (!json.contains(key) || !json[key].is_number_integer()) return std::nullopt;
  return json[key].get<std::int64_t>();
}

// What this version would not take as tags is none.
std::vector<std::string> TagsOf(const Json& json) {
  std::vector<std::string> tags;
  for (const Json& tag : json) {
    if (tag.is_string()) tags.push_back(tag.get<std::string>());
  }
  Result<std::vector<std::string>> checked = CheckedTags(std::move(tags));
  return checked ? *std::move(checked) : std::vector<std::string>();
}

void TakeFlight(const Json& fields, FlightRecord& record) {
  if (auto name = TextIn(fields, "name")) record.name = std::move(name);
  if (auto options = TextIn(fields, "options")) record.options = std::move(options);
  if (auto owner = TextIn(fields, "owner")) record.owner = std::move(owner);
  if (const auto created = NumberOf(fields, "created_us")) record.created = FromUs(*created);
  if (fields.contains("tags") && fields["tags"].is_array()) record.tags = TagsOf(fields["tags"]);
  if (fields.contains("keep") && fields["keep"].is_boolean()) record.is_kept = fields["keep"].get<bool>();
  if (fields.contains("trashed_us")) {
    const auto trashed = NumberOf(fields, "trashed_us");
    record.trashed = trashed ? std::optional(FromUs(*trashed)) : std::nullopt;
  }
  record.is_deleting = false;
}

// False: it is no line of a record. `newest`: stored names by the user's.
bool TakeLine(const Json& line, FlightRecord& record, std::map<std::string, std::string>& newest) {
  if (!line.is_object()) return false;
  if (line.contains("flight") && line["flight"].is_object()) {
    TakeFlight(line["flight"], record);
    return true;
  }
  if (line.contains("file") && line["file"].is_object()) {
    const auto stored = TextIn(line["file"], "stored");
    const auto name = TextIn(line["file"], "name");
    const auto bytes = NumberOf(line["file"], "bytes");
    const auto created = NumberOf(line["file"], "created_us");
    if (!stored || !name || !bytes || !created) return false;
    record.files[*stored] = {*name, *bytes, FromUs(*created), false};
    const std::string before = std::exchange(newest[*name], *stored);
    if (!before.empty() && before != *stored) record.files[before].replaced_by = *stored;
    return true;
  }
  if (const auto removed = TextIn(line, "removed")) {
    const auto found = record.files.find(*removed);
    if (found != record.files.end()) found->second.is_removed = true;
    return true;
  }
  if (NumberOf(line, "deleting")) return record.is_deleting = true;
  if (NumberOf(line, "deleted")) return record.is_deleted = true;
  return false;
}

}  // namespace

FlightRecord ParseFlightRecord(std::string_view text) {
  FlightRecord record;
  std::map<std::string, std::string> newest;
  bool is_first = true;
  bool is_whole = true;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const bool is_torn = end == std::string_view::npos;  // it was never said to be done
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(is_torn ? text.size() : end + 1);
    if (line.empty()) continue;
    const Json json = ParseJson(line);
    const bool is_taken = !json.is_discarded() && TakeLine(json, record, newest);
    if (is_first) is_whole = is_taken && record.name.has_value();
    if (!is_taken && !is_torn) is_whole = false;
    is_first = false;
  }
  record.is_whole = is_whole && !is_first;
  return record;
}

Result<std::optional<FlightRecord>> ReadFlightRecord(const std::filesystem::path& flight_folder) {
  const std::filesystem::path path = flight_folder / kFlightRecordName;
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return std::optional<FlightRecord>();
  SKYQUILT_TRY_ASSIGN(const std::string text, ReadWholeFile(path));
  return std::optional<FlightRecord>(ParseFlightRecord(text));
}

bool FlightRecords::Has(const std::string& flight_id) const {
  std::error_code none;
  return std::filesystem::exists(dir_.Flight(flight_id) / kFlightRecordName, none);
}

bool FlightRecords::AreAllThatIsHere() const {
  std::error_code none;
  return std::filesystem::exists(dir_.BlobsMarker(), none);
}

Result<void> FlightRecords::Begin(const std::string& flight_id, const FlightRecord& record) const {
  const std::filesystem::path folder = dir_.Flight(flight_id);
  if (mkdir(folder.c_str(), 0755) == 0) {
    const Result<void> synced = SyncFolder(dir_.Flights());
    if (!synced) return NotStored(synced.error());
  } else if (errno == ENOENT) {
    return Error{ErrorCode::kUnavailable, "The server's data folder is gone. Try again when it is back.",
                 folder.string()};
  } else if (errno != EEXIST) {
    return NotStored(FileError("cannot make", folder, errno));
  }
  std::string text = LineOf(FlightLine(record));
  for (const auto& [stored_name, file] : record.files) text += LineOf(FileLine(stored_name, file));
  const Result<void> written = WriteFileAtomically(folder / kFlightRecordName, text);
  if (!written) return NotStored(written.error());
  return {};
}

Result<void> FlightRecords::Change(const std::string& flight_id, const FlightRecord& change) const {
  return Append(flight_id, LineOf(FlightLine(change)));
}

Result<void> FlightRecords::SetTrashed(const std::string& flight_id, std::optional<Time> trashed) const {
  const Json time = trashed ? Json(ToUs(*trashed)) : Json(nullptr);
  return Append(flight_id, LineOf({{"flight", {{"trashed_us", time}}}}));
}

Result<void> FlightRecords::AddFile(const std::string& flight_id, const std::string& stored_name,
                                    const RecordedFile& file) const {
  return Append(flight_id, LineOf(FileLine(stored_name, file)));
}

Result<void> FlightRecords::RemoveFile(const std::string& flight_id, const std::string& stored_name) const {
  return Append(flight_id, LineOf({{"removed", stored_name}}));
}

Result<void> FlightRecords::Deleting(const std::string& flight_id, Time now) const {
  return Append(flight_id, LineOf({{"deleting", ToUs(now)}}));
}

Result<void> FlightRecords::Deleted(const std::string& flight_id, Time now) const {
  return Append(flight_id, LineOf({{"deleted", ToUs(now)}}));
}

void FlightRecords::Undo(const std::string& flight_id) const {
  unlink((dir_.Flight(flight_id) / kFlightRecordName).c_str());
  rmdir(dir_.Flight(flight_id).c_str());  // fails, and rightly, where anything else is in it
}

Result<void> FlightRecords::Append(const std::string& flight_id, const std::string& line) const {
  const std::filesystem::path path = dir_.Flight(flight_id) / kFlightRecordName;
  // A flight without a record (one of an earlier version, brought here while the server ran) gets one that
  // does not claim to be whole.
  const FileDescriptor file(open(path.c_str(), O_RDWR | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0640));
  if (!file.is_open() && errno == ENOENT) {
    if (access(dir_.Flights().c_str(), F_OK) != 0) {
      return Error{ErrorCode::kUnavailable, "The server's data folder is gone. Try again when it is back.",
                   path.string()};
    }
    return Error{ErrorCode::kNotFound, "The folder of this flight is gone.", path.string()};
  }
  if (!file.is_open()) return NotStored(FileError("cannot open", path, errno));
  const off_t size = lseek(file.get(), 0, SEEK_END);
  char last = '\n';
  std::string text = line;
  // After a torn line a new one must not become part of it.
  if (size > 0 && file.ReadAt(static_cast<std::uint64_t>(size - 1), &last, 1) == 1 && last != '\n')
    text.insert(text.begin(), '\n');
  const ssize_t wrote = write(file.get(), text.data(), text.size());
  if (wrote != static_cast<ssize_t>(text.size())) {
    const Error failed = FileError("cannot write", path, wrote < 0 ? errno : ENOSPC);
    (void)!ftruncate(file.get(), size);  // a part of a line that stays is passed over as torn
    return NotStored(failed);
  }
  if (fdatasync(file.get()) != 0) return NotStored(FileError("cannot write", path, errno));
  return {};
}

}  // namespace skyquilt::storage
