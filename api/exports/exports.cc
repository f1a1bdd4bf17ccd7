#include "api/exports/exports.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/common/find_flight.h"
#include "api/downloads/send_file.h"
#include "api/http/once.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/json/json_text.h"
#include "api/routes.h"
#include "api/tiles/index_values.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_json.h"
#include "storage/exports/custom/export_request.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

using storage::ExportState;
using storage::MapExport;
using Value = nlohmann::ordered_json;

std::string AddressOfExport(const MapExport& made) {
  return fmt::format("/api/v1/flights/{}/exports/{}", made.flight_id, made.id);
}

// What is to be known of the file; null: nothing, or the map is gone.
Value RemarkOn(Service& service, const MapExport& made, const Value& crs) {
  if (!crs.is_string()) return {};
  const auto tileset = service.tilesets.Get(made.flight_id);
  if (!tileset) return {};
  const auto facts = storage::FactsOfTileset((*tileset)->reader->metadata());
  if (!facts) return {};
  const auto remark = storage::RemarkOnCrs(crs.get<std::string>(), facts->bounds.Middle());
  return remark ? flight::JsonOfRemark<Value>(*remark) : Value();
}

Value ExportJson(Service& service, const Request& asked, const MapExport& made, std::int64_t shown_revision) {
  const Value request = ParseOrderedJson(made.request);
  const auto wished = [&](const char* field) {
    return request.is_object() && request.contains(field) ? request[field] : Value();
  };
  const bool is_there = made.state == ExportState::kSuccessful;
  Value json;
  json["id"] = made.id;
  json["flight_id"] = made.flight_id;
  json["revision"] = made.revision;
  json["is_current"] = made.revision == shown_revision;
  json["format"] = made.format;
  json["crs"] = wished("crs");
  json["resolution_m"] = wished("resolution_m");
  json["boundary"] = wished("boundary");
  json["index"] = wished("index");
  json["expression"] = wished("expression");
  json["remark"] = RemarkOn(service, made, json["crs"]);
  json["state"] = storage::NameOf(made.state);
  json["progress"] = made.progress;
  json["bytes"] = is_there ? Value(made.bytes) : Value();
  json["error"] = made.state == ExportState::kFailed
                      ? Value({{"code", made.error_code},
                               {"message", made.error_message},
                               {"reason", flight::ReasonValue<Value>(made.error_reason)}})
                      : Value();
  json["created_at"] = FormatTime(made.created);
  json["finished_at"] = made.finished ? Value(FormatTime(*made.finished)) : Value();
  json["expires_at"] = made.expires ? Value(FormatTime(service.db.ages().OnTheWall(*made.expires))) : Value();
  const std::string address = asked.base_path + AddressOfExport(made);
  json["href"] = address;
  json["download"] = is_there ? Value(address + "/file") : Value();
  return json;
}

// What the map is, as far as exports depend on it.
Result<storage::MapFacts> FactsOfShownMap(Service& service, const ShownMap& map,
                                          const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const auto tileset, service.tilesets.Get(flight_id));
  SKYQUILT_TRY_ASSIGN(storage::MapFacts facts, storage::FactsOfTileset(tileset->reader->metadata()));
  facts.gsd_m = tileset->revision.gsd_m;
  const Result<storage::LocalBlob> report = FetchProduct(service, map, "report.json");
  if (!report && report.error().code != ErrorCode::kNotFound) return report.error();
  if (!report) return facts;
  SKYQUILT_TRY_ASSIGN(const std::string text, storage::ReadWholeFile(report->path));
  const auto json = ParseJson(text);
  if (json.is_object() && json.contains("is_placed") && json["is_placed"].is_boolean())
    facts.is_placed = json["is_placed"].get<bool>();
  return facts;
}

Result<Response> AskForExport(Service& service, const Request& request, const std::string& body) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY_ASSIGN(const ShownMap map, FindShownMap(service, flight_id));
  SKYQUILT_TRY(CheckJsonText(body));
  SKYQUILT_TRY_ASSIGN(const storage::ExportRequest wish, storage::ParseExportRequest(body));
  SKYQUILT_TRY_ASSIGN(const storage::MapFacts facts, FactsOfShownMap(service, map, flight_id));
  SKYQUILT_TRY(storage::CheckExport(wish, facts));
  if (wish.IsOfValues()) {
    SKYQUILT_TRY_ASSIGN(const auto tileset, service.tilesets.Get(flight_id));
    const Result<void> has_bands = CheckBands(service.bands, *tileset, storage::ExpressionOf(wish));
    if (!has_bands && has_bands.error().code == ErrorCode::kInvalidArgument)
      return flight::Because(ErrorCode::kUnprocessable, flight::WhyOf(has_bands.error()));
    if (!has_bands) return has_bands.error();
  }
  if (wish.format == storage::ExportFormat::kReport && !service.prints_pdf())
    return flight::Because(ErrorCode::kUnavailable, flight::RemarkCode::kExportWithoutPrinter);
  MapExport wanted;
  wanted.flight_id = flight_id;
  wanted.revision = map.revision;
  nlohmann::json request_json = ParseJson(body);
  // Under another name it is another report.
  if (wish.format == storage::ExportFormat::kReport && wish.name.empty())
    request_json["name"] = map.flight_name;
  wanted.request = JsonText(request_json);  // so that the same wish is known again
  wanted.format = storage::NameOf(wish.format);
  wanted.owner = request.owner;
  wanted.is_of_link = !request.only_flight.empty();
  SKYQUILT_TRY_ASSIGN(const MapExport added,
                      service.db.Again([&] { return service.exports.Add(wanted, storage::Now()); }));
  Response response = JsonOf(202, ExportJson(service, request, added, map.revision));
  response.headers.Add("Location", AddressOfExport(added));
  return response;
}

Result<std::int64_t> ShownRevisionOf(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  return flight.active_revision.value_or(0);
}

Result<Response> ListExports(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY_ASSIGN(const std::int64_t shown, ShownRevisionOf(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<MapExport> exports, service.exports.List(flight_id));
  Value items = Value::array();
  for (const MapExport& one : exports) {
    if (!service.exports.HasExpired(one)) items.push_back(ExportJson(service, request, one, shown));
  }
  return JsonOf(200, {{"exports", items}});
}

Result<MapExport> FindExport(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckId(request.Parameter("flight"), "flight"));
  SKYQUILT_TRY(CheckId(request.Parameter("export"), "export"));
  return service.exports.Get(request.Parameter("flight"), request.Parameter("export"));
}

Result<Response> ShowExport(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const MapExport found, FindExport(service, request));
  SKYQUILT_TRY_ASSIGN(const std::int64_t shown, ShownRevisionOf(service, found.flight_id));
  return JsonOf(200, ExportJson(service, request, found, shown));
}

Result<Response> RemoveExport(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const MapExport found, FindExport(service, request));
  const bool is_own = !request.owner.empty() && request.owner == found.owner;
  if (!is_own) SKYQUILT_TRY(CheckMayChange(service, request, found.flight_id));
  // The row first: whoever makes it sees that it is nobody's, and leaves no file.
  SKYQUILT_TRY(service.db.Free([&] { return service.exports.Remove(found.id); }));
  SKYQUILT_TRY(service.store.blobs().Remove(storage::ExportKey(found)));
  return NoContent();
}

Result<Response> DownloadExport(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const MapExport found, FindExport(service, request));
  const auto format = storage::ExportFormatOfName(found.format);
  if (found.state != ExportState::kSuccessful || !format)
    return Error{ErrorCode::kConflict, found.HasEnded()
                                           ? "This export failed: " + found.error_message
                                           : "This export is not made yet. Ask its address for its state."};
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(found.flight_id));
  SKYQUILT_TRY_ASSIGN(Response sent,
                      SendBlob(request, service.store.blobs(), storage::ExportKey(found),
                               storage::ContentTypeOf(*format), fmt::format("\"{}\"", found.id)));
  if (sent.status != 304)
    sent.headers.Add("Content-Disposition", Disposition(flight.name, storage::EndingOf(*format)));
  sent.headers.Add("Cache-Control", "private, max-age=3600");
  return sent;
}

}  // namespace

void AddExportRoutes(Router& router, Service& service) {
  constexpr const char* kAll = "/api/v1/flights/{flight}/exports";
  constexpr const char* kOne = "/api/v1/flights/{flight}/exports/{export}";
  // Another form of what may be downloaded anyway: no flight changes.
  constexpr storage::Scope kReads = storage::Scope::kRead;
  router
      .AddBody(
          Method::kPost, kAll,
          [&](const Request& request, const std::string& body) {
            return Once(service, request, body, [&] { return AskForExport(service, request, body); });
          },
          "Send the wish as JSON with its header: curl -H 'Content-Type: application/json' -d "
          "'{\"format\":\"geotiff\"}' ...")
      .scope = kReads;
  router.Add(Method::kGet, kAll, On(service, ListExports));
  router.Add(Method::kGet, kOne, On(service, ShowExport));
  router.Add(Method::kDelete, kOne, On(service, RemoveExport)).scope = kReads;
  router.Add(Method::kGet, "/api/v1/flights/{flight}/exports/{export}/file",
             [&](const Request& request) { return Downloaded(DownloadExport(service, request), request); });
}

Result<int> RemoveExpiredExports(Service& service) {
  SKYQUILT_TRY(service.exports.EndThoseOfEndedLinks(storage::Now()));
  SKYQUILT_TRY_ASSIGN(const std::vector<MapExport> expired, service.exports.Expired());
  for (const MapExport& one : expired) {
    // The file first: a row without one says what it is, a file without a row nobody knows.
    SKYQUILT_TRY(service.store.blobs().Remove(storage::ExportKey(one)));
    SKYQUILT_TRY(service.exports.Remove(one.id));
  }
  return static_cast<int>(expired.size());
}

}  // namespace skyquilt::api
