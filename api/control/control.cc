// The surveyed points of a flight and their marks: read, and written as a whole. They lie among the flight's
// files as the list that the stitcher reads.
#include <nlohmann/json.hpp>
#include <utility>

#include "api/common/find_flight.h"
#include "api/control/control_list.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/uploads/flight_document.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr const char* kListName = "gcp_list.txt";

struct KeptControl {
  std::string json;
  std::string etag;
};

Result<std::string> ReadStoredList(Service& service, const std::string& flight_id,
                                   const std::string& stored_name) {
  SKYQUILT_TRY_ASSIGN(const storage::LocalBlob blob, service.store.Fetch(flight_id, stored_name));
  if (!service.read_control) return Error{ErrorCode::kUnavailable, "This server reads no control points."};
  return service.read_control(blob.path);
}

Result<KeptControl> ReadControlOf(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  KeptControl kept{NoControlJson(), EtagOfDocument("")};
  SKYQUILT_TRY(ReadDocument(service, flight_id, kListName, [&](const auto& list) -> Result<void> {
    kept = {NoControlJson(), EtagOfDocument(list)};
    if (!list) return {};
    SKYQUILT_TRY_ASSIGN(kept.json, ReadStoredList(service, flight_id, list->stored_name));
    return {};
  }));
  return kept;
}

std::size_t PointsAndMarks(const nlohmann::json& control) {
  std::size_t count = 0;
  if (!control.is_object() || !control.contains("points")) return count;
  for (const auto& point : control["points"])
    count += 1 + (point.is_object() && point.contains("marks") ? point["marks"].size() : 0);
  return count;
}

// Points that the list's reader left out would be lost without a word.
Result<void> CheckAllWereRead(const std::string& given, const std::string& json) {
  const auto read = ParseJson(json);
  if (PointsAndMarks(read) == PointsAndMarks(ParseJson(given))) return {};
  std::string words = "some of them cannot be read.";
  if (read.is_object() && read.contains("warnings") && !read["warnings"].empty() &&
      read["warnings"].front().is_string())
    words = read["warnings"].front().get<std::string>();
  return Error{ErrorCode::kUnprocessable, "The control points cannot be kept: " + words};
}

// The reader speaks of files; here the user's fields are meant.
Error AsRefusal(const Error& error) {
  if (error.code == ErrorCode::kUnsupportedFormat)
    return {ErrorCode::kUnprocessable, "The reference system is not known: " + error.message};
  if (error.code == ErrorCode::kCorrupt)
    return {ErrorCode::kUnprocessable, "None of the points lies in the area of the reference system."};
  return error;
}

Result<KeptControl> WriteControl(Service& service, const Request& request, const std::string& body) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::string text, ControlListText(body));
  SKYQUILT_TRY_ASSIGN(const auto list, FindDocument(service, flight_id, kListName));
  SKYQUILT_TRY_ASSIGN(
      const WantedDocument wanted,
      CheckIfMatch(request, list,
                   "The control points were changed elsewhere meanwhile. Read them again, then "
                   "repeat the change."));
  if (text.empty()) {
    SKYQUILT_TRY(RemoveDocument(service, flight_id, list, wanted));
    return KeptControl{NoControlJson(), EtagOfDocument("")};
  }
  std::string read;
  const auto check = [&](const std::string& stored) -> Result<void> {
    Result<std::string> json = ReadStoredList(service, flight_id, stored);
    if (!json) return AsRefusal(json.error());
    read = *std::move(json);
    return CheckAllWereRead(body, read);
  };
  SKYQUILT_TRY_ASSIGN(const std::string stored,
                      ReplaceDocument(service, flight_id, list, kListName, wanted, text, check));
  return KeptControl{std::move(read), EtagOfDocument(stored)};
}

Result<Response> AnswerControl(const Result<KeptControl>& kept) {
  if (!kept) return kept.error();
  Response response = Json(200, kept->json);
  response.headers.Add("ETag", kept->etag);
  return response;
}

}  // namespace

void AddControlRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/control", [&](const Request& request) {
    return AnswerControl(ReadControlOf(service, request.Parameter("flight")));
  });
  router.AddBody(
      Method::kPut, "/api/v1/flights/{flight}/control",
      [&](const Request& request, const std::string& body) {
        return AnswerControl(WriteControl(service, request, body));
      },
      "Send the control points as JSON with its header, Content-Type: application/json.", kMaxControlBytes);
}

}  // namespace skyquilt::api
