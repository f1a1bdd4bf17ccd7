#include "api/uploads/flight_document.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "api/auth/limits.h"
#include "api/http/conditional.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

Result<std::string> StoreText(Service& service, const std::string& flight_id, const std::string& text) {
  SKYQUILT_TRY_ASSIGN(storage::Upload upload,
                      service.store.Begin(flight_id, static_cast<std::int64_t>(text.size())));
  SKYQUILT_TRY(upload.Write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  return upload.Finish();
}

}  // namespace

Result<std::optional<storage::StoredFile>> FindDocument(Service& service, const std::string& flight_id,
                                                        std::string_view name) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files, service.catalogue.ListFiles(flight_id));
  for (const storage::StoredFile& file : files) {
    if (EqualsIgnoringCase(file.name, name)) return std::optional(file);
  }
  return std::optional<storage::StoredFile>();
}

Result<void> ReadDocument(
    Service& service, const std::string& flight_id, std::string_view name,
    const std::function<Result<void>(const std::optional<storage::StoredFile>&)>& read) {
  constexpr int kMaxTurns = 5;
  SKYQUILT_TRY_ASSIGN(std::optional<storage::StoredFile> file, FindDocument(service, flight_id, name));
  for (int turn = 1;; ++turn) {
    Result<void> done = read(file);
    if (done || !file || turn == kMaxTurns) return done;
    SKYQUILT_TRY_ASSIGN(std::optional<storage::StoredFile> now, FindDocument(service, flight_id, name));
    if (now && now->stored_name == file->stored_name) return done;
    file = std::move(now);
  }
}

std::string EtagOfDocument(const std::string& stored_name) {
  return "\"" + (stored_name.empty() ? "none" : stored_name) + "\"";
}

std::string EtagOfDocument(const std::optional<storage::StoredFile>& file) {
  return EtagOfDocument(file ? file->stored_name : std::string());
}

Result<WantedDocument> CheckIfMatch(const Request& request, const std::optional<storage::StoredFile>& known,
                                    const char* refusal) {
  const std::string_view if_match = request.headers.Find("If-Match");
  if (if_match.empty()) return WantedDocument{};
  if (!EtagListMatches(if_match, EtagOfDocument(known)))
    return Error{ErrorCode::kPreconditionFailed, refusal};
  return WantedDocument{known ? known->stored_name : std::string()};
}

Result<std::string> ReplaceDocument(
    Service& service, const std::string& flight_id, const std::optional<storage::StoredFile>& known,
    const char* name, const WantedDocument& wanted, const std::string& text,
    const std::function<Result<void>(const std::string& stored_name)>& check) {
  const auto bytes = static_cast<std::int64_t>(text.size());
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, flight_id));
  SKYQUILT_TRY(incoming.Take(bytes));
  SKYQUILT_TRY_ASSIGN(const std::string stored, StoreText(service, flight_id, text));
  const auto add = [&]() -> Result<storage::AddedFile> {
    SKYQUILT_TRY(check(stored));
    const storage::StoredFile file{known ? known->name : name, stored, bytes};
    return service.catalogue.AddFile(flight_id, file, storage::Now(), wanted.stored_name);
  };
  const Result<storage::AddedFile> added = add();
  if (!added) {
    service.store.TakeBack(flight_id, stored, added.error());
    return added.error();
  }
  incoming.Kept(bytes);
  if (added->replaced) {
    service.store.Remove(flight_id, added->replaced_stored_name);
    incoming.Freed(added->replaced_bytes);
  }
  return stored;
}

Result<void> RemoveDocument(Service& service, const std::string& flight_id,
                            const std::optional<storage::StoredFile>& known, const WantedDocument& wanted) {
  if (!known) return {};
  SKYQUILT_TRY_ASSIGN(const storage::StoredFile removed, service.db.Free([&] {
    return service.catalogue.RemoveFile(flight_id, known->name, wanted.stored_name);
  }));
  service.store.Remove(flight_id, removed.stored_name);
  return {};
}

}  // namespace skyquilt::api
