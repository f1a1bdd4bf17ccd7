#include "api/control/control.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "api/auth/flight_access.h"
#include "api/control/control_list.h"
#include "api/flights/flights.h"
#include "api/http/etag.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr const char* kListName = "gcp_list.txt";

struct KeptControl {
  std::string json;
  std::string etag;
};

std::string EtagOfList(const std::string& stored_name) {
  return "\"" + (stored_name.empty() ? "none" : stored_name) + "\"";
}

// In any case, as a user may have sent it.
Result<std::optional<storage::StoredFile>> FindList(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files, service.catalogue.ListFiles(flight_id));
  for (const storage::StoredFile& file : files) {
    if (EqualsIgnoringCase(file.name, kListName)) return std::optional(file);
  }
  return std::optional<storage::StoredFile>();
}

Result<std::string> ReadStoredList(Service& service, const std::string& flight_id,
                                   const std::string& stored_name) {
  SKYQUILT_TRY_ASSIGN(const storage::LocalBlob blob, service.store.Fetch(flight_id, stored_name));
  if (!service.read_control)
    return Error{ErrorCode::kUnavailable, "This server reads no control points.", ""};
  return service.read_control(blob.path);
}

Result<KeptControl> ReadControlOf(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const auto list, FindList(service, flight_id));
  if (!list) return KeptControl{NoControlJson(), EtagOfList("")};
  SKYQUILT_TRY_ASSIGN(std::string json, ReadStoredList(service, flight_id, list->stored_name));
  return KeptControl{std::move(json), EtagOfList(list->stored_name)};
}

// Points that the list's reader left out would be lost without a word.
Result<void> CheckAllWereRead(const std::string& json) {
  const auto read = nlohmann::json::parse(json, nullptr, false);
  if (!read.is_object() || !read.contains("warnings") || read["warnings"].empty()) return {};
  const auto& first = read["warnings"].front();
  const std::string words = first.is_string() ? first.get<std::string>() : "";
  if (words.starts_with("all heights")) return {};  // said to the user with the answer
  return Error{ErrorCode::kUnprocessable, "The control points cannot be kept: " + words, ""};
}

// The reader speaks of files; here the user's fields are meant.
Error AsRefusal(const Error& error) {
  if (error.code == ErrorCode::kUnsupportedFormat)
    return {ErrorCode::kUnprocessable, "The reference system is not known: " + error.message, ""};
  if (error.code == ErrorCode::kCorrupt)
    return {ErrorCode::kUnprocessable, "None of the points lies in the area of the reference system.", ""};
  return error;
}

Result<std::string> StoreList(Service& service, const std::string& flight_id, const std::string& text) {
  SKYQUILT_TRY_ASSIGN(storage::Upload upload,
                      service.store.Begin(flight_id, static_cast<std::int64_t>(text.size())));
  SKYQUILT_TRY(upload.Write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  return upload.Finish();
}

Error ControlChangedMeanwhile() {
  return {ErrorCode::kPreconditionFailed,
          "The control points were changed elsewhere meanwhile. Read them again, then repeat the change.",
          ""};
}

Result<KeptControl> ClearControl(Service& service, const std::string& flight_id,
                                 const std::optional<storage::StoredFile>& list) {
  if (list) {
    SKYQUILT_TRY_ASSIGN(const storage::StoredFile removed,
                        service.db.Free([&] { return service.catalogue.RemoveFile(flight_id, list->name); }));
    service.store.Remove(flight_id, removed.stored_name);
  }
  return KeptControl{NoControlJson(), EtagOfList("")};
}

Result<KeptControl> WriteControl(Service& service, const Request& request, const std::string& body) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::string text, ControlListText(body));
  SKYQUILT_TRY_ASSIGN(const auto list, FindList(service, flight_id));
  const std::string known = list ? list->stored_name : "";
  const std::string_view wanted = request.headers.Find("If-Match");
  if (!wanted.empty() && !EtagListMatches(wanted, EtagOfList(known))) return ControlChangedMeanwhile();
  if (text.empty()) return ClearControl(service, flight_id, list);

  const auto bytes = static_cast<std::int64_t>(text.size());
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, flight_id));
  SKYQUILT_TRY(incoming.Take(bytes));
  SKYQUILT_TRY_ASSIGN(const std::string stored, StoreList(service, flight_id, text));
  const auto add = [&]() -> Result<KeptControl> {
    Result<std::string> json = ReadStoredList(service, flight_id, stored);
    if (!json) return AsRefusal(json.error());
    SKYQUILT_TRY(CheckAllWereRead(*json));
    const storage::StoredFile file{list ? list->name : kListName, stored, bytes};
    const std::optional<std::string> expected = wanted.empty() ? std::nullopt : std::optional(known);
    SKYQUILT_TRY_ASSIGN(const storage::AddedFile added,
                        service.catalogue.AddFile(flight_id, file, storage::Now(), expected));
    incoming.Kept(bytes);
    if (added.replaced) {
      service.store.Remove(flight_id, added.replaced_stored_name);
      incoming.Freed(list ? list->bytes : 0);
    }
    return KeptControl{*std::move(json), EtagOfList(stored)};
  };
  Result<KeptControl> kept = add();
  if (!kept) service.store.Remove(flight_id, stored);
  return kept;
}

Response AnswerControl(const Result<KeptControl>& kept, const Request& request) {
  if (!kept) return Problem(kept.error(), request);
  Response response = Json(200, kept->json);
  response.headers.Add("ETag", kept->etag);
  return response;
}

}  // namespace

void AddControlRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/control", [&](const Request& request) {
    return AnswerControl(ReadControlOf(service, request.Parameter("flight")), request);
  });
  router.AddUpload(
      Method::kPut, "/api/v1/flights/{flight}/control",
      [&](const Request& request) -> std::variant<std::unique_ptr<BodySink>, Response> {
        if (!IsJson(request)) {
          return Problem(
              {ErrorCode::kUnsupportedFormat,
               "Send the control points as JSON with its header, Content-Type: application/json.", ""},
              request);
        }
        return CollectBody(
            [&service, request](const std::string& body) {
              return AnswerControl(WriteControl(service, request, body), request);
            },
            kMaxControlBytes);
      });
}

}  // namespace skyquilt::api
