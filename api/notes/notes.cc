// The notes and measurements of a flight, which everybody sees who opens it: read, and written as a whole.
// They lie among the flight's files, as GeoJSON.
#include <optional>
#include <utility>

#include "api/common/find_flight.h"
#include "api/forms/geojson_body.h"
#include "api/http/responses.h"
#include "api/notes/note_list.h"
#include "api/routes.h"
#include "api/uploads/flight_document.h"
#include "core/base/try.h"
#include "core/flight/bytes/input_file.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

struct KeptNotes {
  NotesText text;
  std::string etag;
};

Result<NotesText> ReadStoredNotes(Service& service, const std::string& flight_id,
                                  const storage::StoredFile& file) {
  const auto unreadable = [&](const std::string& why) {
    return Error{ErrorCode::kUnprocessable,
                 "The file " + file.name + " of this flight holds no notes that can be read: " + why +
                     " Remove it from the flight's files, or put one in its place that holds some."};
  };
  if (file.bytes > static_cast<std::int64_t>(kMaxNotesBytes)) return unreadable("It is too large.");
  SKYQUILT_TRY_ASSIGN(const storage::LocalBlob blob, service.store.Fetch(flight_id, file.stored_name));
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(blob.path));
  Result<NotesText> read = ReadNotes(bytes);
  if (!read) return unreadable(read.error().message);
  return read;
}

Result<KeptNotes> ReadNotesOf(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  KeptNotes kept{NoNotes(), EtagOfDocument("")};
  SKYQUILT_TRY(ReadDocument(service, flight_id, flight::kMapNotesName, [&](const auto& file) -> Result<void> {
    kept = {NoNotes(), EtagOfDocument(file)};
    if (!file) return {};
    SKYQUILT_TRY_ASSIGN(kept.text, ReadStoredNotes(service, flight_id, *file));
    return {};
  }));
  return kept;
}

// Who does not say what he replaces may replace nothing that somebody wrote.
Result<WantedDocument> WantedNotes(Service& service, const Request& request,
                                   const std::optional<storage::StoredFile>& known) {
  SKYQUILT_TRY_ASSIGN(WantedDocument wanted,
                      CheckIfMatch(request, known,
                                   "The notes were changed elsewhere meanwhile. Read them again, then repeat "
                                   "the change."));
  if (!wanted.stored_name && known) {
    const Result<NotesText> kept = ReadStoredNotes(service, request.Parameter("flight"), *known);
    if (!kept || kept->count > 0) {
      return Error{ErrorCode::kPreconditionFailed,
                   "This flight has notes already. Read them, add yours, and send them with the header "
                   "If-Match: their ETag, so that none is lost."};
    }
  }
  wanted.stored_name = known ? known->stored_name : std::string();
  return wanted;
}

Result<KeptNotes> WriteNotes(Service& service, const Request& request, const std::string& body) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(NotesText text, ReadNotes(body));
  SKYQUILT_TRY_ASSIGN(const auto known, FindDocument(service, flight_id, flight::kMapNotesName));
  SKYQUILT_TRY_ASSIGN(const WantedDocument wanted, WantedNotes(service, request, known));
  if (text.count == 0 && !known) return KeptNotes{std::move(text), EtagOfDocument(known)};
  SKYQUILT_TRY_ASSIGN(const std::string stored,
                      ReplaceDocument(service, flight_id, known, flight::kMapNotesName, wanted, text.json,
                                      [](const std::string& /*stored_name*/) { return Result<void>(); }));
  return KeptNotes{std::move(text), EtagOfDocument(stored)};
}

Result<Response> AnswerNotes(Result<KeptNotes> kept) {
  if (!kept) return kept.error();
  Response response = NoCache(Text(200, std::move(kept->text.json), "application/geo+json"));
  response.headers.Add("ETag", kept->etag);
  return response;
}

}  // namespace

void AddNotesRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/notes", [&](const Request& request) {
    return AnswerNotes(ReadNotesOf(service, request.Parameter("flight")));
  });
  router.AddUpload(
      Method::kPut, "/api/v1/flights/{flight}/notes", [&](const Request& request) -> UploadBegun {
        if (!IsGeoJson(request))
          return Error{ErrorCode::kUnsupportedFormat,
                       "Send the notes as GeoJSON with its header, Content-Type: application/geo+json."};
        return CollectBody(
            request,
            [&service](const Request& of, const std::string& body) {
              return AnswerNotes(WriteNotes(service, of, body));
            },
            kMaxNotesBytes);
      });
}

}  // namespace skyquilt::api
