#include "api/uploads/unpack.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/text/file_names.h"
#include "core/base/text/printable.h"
#include "core/base/try.h"
#include "storage/uploads/unpack_archive.h"

namespace skyquilt::api {
namespace {

FileOutcome Outcome(std::string name, std::int64_t bytes) {
  FileOutcome outcome;
  outcome.name = std::move(name);
  outcome.bytes = bytes;
  return outcome;
}

std::int64_t SizeOf(const std::vector<storage::UnpackedFile>& files) {
  std::int64_t bytes = 0;
  for (const storage::UnpackedFile& file : files) bytes += file.error ? 0 : file.file.bytes;
  return bytes;
}

Result<std::vector<FileOutcome>> AddAll(Service& service, const std::string& flight_id,
                                        const std::vector<storage::UnpackedFile>& files) {
  std::vector<FileOutcome> outcomes;
  for (std::size_t i = 0; i < files.size(); ++i) {
    outcomes.push_back(Outcome(files[i].file.name, files[i].file.bytes));
    outcomes.back().error = files[i].error;
    if (files[i].error) continue;
    const auto added = service.catalogue.AddFileUnderFreeName(flight_id, files[i].file, storage::Now());
    if (!added) {
      // Those that the catalogue has stay; the others are taken back.
      for (std::size_t rest = i; rest < files.size(); ++rest) {
        if (!files[rest].error)
          service.store.TakeBack(flight_id, files[rest].file.stored_name, added.error());
      }
      return added.error();
    }
    if (added->name != files[i].file.name) {
      outcomes.back().name = added->name;
      outcomes.back().note = fmt::format("\"{}\" was there already, so this one is kept as \"{}\".",
                                         files[i].file.name, added->name);
    }
  }
  return outcomes;
}

void RemoveUnpacked(Service& service, const std::string& flight_id,
                    const std::vector<storage::UnpackedFile>& files) {
  for (const storage::UnpackedFile& one : files) {
    if (!one.error) service.store.Remove(flight_id, one.file.stored_name);
  }
}

// Whether the flight has it already, under its name or, where that was another's, under one with a number, as
// the catalogue gives them.
Result<bool> HasCome(Service& service, const std::string& flight_id, const storage::UnpackedFile& one) {
  constexpr int kMaxNumbers = 20;
  if (one.error) return false;
  std::string name = one.file.name;
  for (int number = 2; number <= kMaxNumbers + 1; ++number) {
    SKYQUILT_TRY_ASSIGN(const std::optional<storage::StoredFile> there,
                        service.catalogue.FindFile(flight_id, name));
    if (!there) return false;
    const Result<bool> is_same = HaveSameBytes(service, flight_id, *there, one.file);
    if (is_same ? *is_same : is_same.error().code != ErrorCode::kNotFound) return is_same;
    name = NumberedName(one.file.name, std::to_string(number));
  }
  return false;
}

// Of what was unpacked, those that came before are taken back.
Result<void> LeaveOutThoseThere(Service& service, const std::string& flight_id,
                                std::vector<storage::UnpackedFile>& files) {
  std::vector<storage::UnpackedFile> there, others;
  for (const storage::UnpackedFile& one : files) {
    SKYQUILT_TRY_ASSIGN(const bool has_come, HasCome(service, flight_id, one));
    (has_come ? there : others).push_back(one);
  }
  RemoveUnpacked(service, flight_id, there);
  files = std::move(others);
  return {};
}

// `goes_on`: some of its files may have come before a server died.
Result<std::vector<FileOutcome>> TakeContent(Service& service, const std::string& flight_id,
                                             const storage::StoredFile& file, IncomingBytes& incoming,
                                             bool goes_on) {
  SKYQUILT_TRY_ASSIGN(const std::optional<std::int64_t> room, incoming.Room());
  // The archive's own bytes are counted still, and go when it is unpacked.
  const std::int64_t max_bytes = room ? *room + file.bytes : std::numeric_limits<std::int64_t>::max();
  const Result<storage::LocalBlob> archive = service.store.Fetch(flight_id, file.stored_name);
  Result<std::vector<storage::UnpackedFile>> unpacked =
      archive ? service.unpack(service.store, flight_id, archive->path, max_bytes) : archive.error();
  if (!unpacked) return unpacked.error().code == ErrorCode::kTooLarge ? incoming.Refusal() : unpacked.error();
  const Result<void> left_out = goes_on ? LeaveOutThoseThere(service, flight_id, *unpacked) : Result<void>();
  const std::int64_t more_bytes = std::max<std::int64_t>(0, SizeOf(*unpacked) - file.bytes);
  const Result<void> taken = left_out ? incoming.Take(more_bytes) : left_out;
  if (!taken) {
    RemoveUnpacked(service, flight_id, *unpacked);
    return taken.error();
  }
  Result<std::vector<FileOutcome>> outcomes = AddAll(service, flight_id, *unpacked);
  incoming.Kept(more_bytes);
  return outcomes;
}

// What its files take of its own bytes is counted already.
void RemoveArchive(Service& service, const std::string& flight_id, const storage::StoredFile& file,
                   const Result<std::vector<FileOutcome>>& outcomes, IncomingBytes& incoming) {
  const Result<storage::StoredFile> removed =
      service.catalogue.RemoveFile(flight_id, file.name, file.stored_name);
  if (!removed) return;  // a job reads the flight: the next start looks again
  service.store.Remove(flight_id, removed->stored_name);
  if (!outcomes) return;  // some of them may have come
  std::int64_t taken_bytes = 0;
  for (const FileOutcome& one : *outcomes) taken_bytes += one.error ? 0 : one.bytes;
  incoming.Freed(std::max<std::int64_t>(0, removed->bytes - taken_bytes));
}

// And not another of its name, which came meanwhile.
Result<bool> IsStillThere(Service& service, const CutOffArchive& archive) {
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::StoredFile> there,
                      service.catalogue.FindFile(archive.flight_id, archive.file.name));
  return there && there->stored_name == archive.file.stored_name;
}

}  // namespace

Result<bool> HaveSameBytes(Service& service, const std::string& flight_id, const storage::StoredFile& one,
                           const storage::StoredFile& other) {
  constexpr std::int64_t kComparedBytes = std::int64_t{4} << 20;
  if (one.bytes != other.bytes) return false;
  const std::string prefix = storage::FilesPrefix(flight_id);
  for (std::int64_t at = 0; at < one.bytes; at += kComparedBytes) {
    SKYQUILT_TRY_ASSIGN(const std::string here,
                        service.store.blobs().ReadRange(prefix + one.stored_name, at, kComparedBytes));
    SKYQUILT_TRY_ASSIGN(const std::string there,
                        service.store.blobs().ReadRange(prefix + other.stored_name, at, kComparedBytes));
    if (here != there) return false;
  }
  return true;
}

// The archive goes last: where a server dies before, the next start goes on with what is there.
Result<std::vector<FileOutcome>> UnpackStored(Service& service, const std::string& flight_id,
                                              const storage::StoredFile& file) {
  if (!storage::IsArchiveName(file.name)) return std::vector<FileOutcome>{Outcome(file.name, file.bytes)};
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, flight_id));
  Result<std::vector<FileOutcome>> outcomes = TakeContent(service, flight_id, file, incoming, false);
  RemoveArchive(service, flight_id, file, outcomes, incoming);
  return outcomes;
}

Result<std::vector<CutOffArchive>> FindCutOff(Service& service) {
  std::vector<CutOffArchive> found;
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, service.catalogue.FlightIds());
  for (const std::string& flight_id : ids) {
    SKYQUILT_TRY_ASSIGN(const bool is_there, service.catalogue.HasFlight(flight_id));
    if (!is_there) continue;  // in the trash
    SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files, service.catalogue.ListFiles(flight_id));
    for (const storage::StoredFile& file : files) {
      if (storage::IsArchiveName(file.name)) found.push_back({flight_id, file});
    }
  }
  return found;
}

Result<std::size_t> UnpackCutOff(Service& service, const CutOffArchive& archive) {
  SKYQUILT_TRY_ASSIGN(const bool is_there, IsStillThere(service, archive));
  if (!is_there) return Error{ErrorCode::kNotFound, "It was removed meanwhile.", ""};
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, archive.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<FileOutcome> outcomes,
                      TakeContent(service, archive.flight_id, archive.file, incoming, true));
  return static_cast<std::size_t>(
      std::count_if(outcomes.begin(), outcomes.end(), [](const FileOutcome& one) { return !one.error; }));
}

Result<void> RemoveCutOff(Service& service, const CutOffArchive& archive) {
  SKYQUILT_TRY_ASSIGN(const bool is_there, IsStillThere(service, archive));
  if (!is_there) return {};
  SKYQUILT_TRY(service.catalogue.RemoveFile(archive.flight_id, archive.file.name, archive.file.stored_name));
  service.store.Remove(archive.flight_id, archive.file.stored_name);
  return {};
}

Result<std::vector<FileOutcome>> UnpackOnly(Service& service, const std::string& flight_id,
                                            const storage::StoredFile& file) {
  SKYQUILT_TRY_ASSIGN(std::vector<FileOutcome> outcomes, UnpackStored(service, flight_id, file));
  const bool is_any_taken =
      std::any_of(outcomes.begin(), outcomes.end(), [](const FileOutcome& one) { return !one.error; });
  if (outcomes.empty() || is_any_taken) return outcomes;
  return Error{ErrorCode::kUnprocessable,
               fmt::format("None of the {} in \"{}\" was taken. The first, \"{}\": {}",
                           Counted(outcomes.size(), "file"), file.name, outcomes.front().name,
                           outcomes.front().error->message)};
}

}  // namespace skyquilt::api
