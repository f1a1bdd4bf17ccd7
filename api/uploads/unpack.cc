#include "api/uploads/unpack.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

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

}  // namespace

Result<std::vector<FileOutcome>> UnpackStored(Service& service, const std::string& flight_id,
                                              const storage::StoredFile& file) {
  if (!storage::IsArchiveName(file.name)) return std::vector<FileOutcome>{Outcome(file.name, file.bytes)};
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::int64_t> room, incoming.Room());
  // The archive's own bytes are counted still, and go when it is unpacked.
  const std::int64_t max_bytes = room ? *room + file.bytes : std::numeric_limits<std::int64_t>::max();
  const Result<storage::LocalBlob> archive = service.store.Fetch(flight_id, file.stored_name);
  const Result<std::vector<storage::UnpackedFile>> unpacked =
      archive ? service.unpack(service.store, flight_id, archive->path, max_bytes) : archive.error();
  const Result<storage::StoredFile> removed = service.catalogue.RemoveFile(flight_id, file.name);
  if (removed) {
    service.store.Remove(flight_id, removed->stored_name);
    incoming.Freed(removed->bytes);
  }
  if (!unpacked) return unpacked.error().code == ErrorCode::kTooLarge ? incoming.Refusal() : unpacked.error();
  const std::int64_t bytes = SizeOf(*unpacked);
  const Result<void> taken = incoming.Take(bytes);
  if (!taken) {
    for (const storage::UnpackedFile& one : *unpacked) {
      if (!one.error) service.store.Remove(flight_id, one.file.stored_name);
    }
    return taken.error();
  }
  Result<std::vector<FileOutcome>> outcomes = AddAll(service, flight_id, *unpacked);
  incoming.Kept(bytes);
  return outcomes;
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
