// For operators and monitoring: liveness, readiness, metrics, version, API contract.
#include <sys/statvfs.h>

#include <string_view>

#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"

namespace skyquilt::api {

extern const std::string_view kOpenApi;  // api/openapi.json

namespace {

constexpr std::uint64_t kMinFreeBytes = std::uint64_t{64} << 20;

Response Ready(Service& service, const Request& request) {
  const auto refuse = [&](const char* why) { return Problem({ErrorCode::kUnavailable, why, ""}, request); };
  if (service.is_draining) return refuse("The server is shutting down.");
  if (const Result<void> in_place = service.storage_in_place(); !in_place)
    return Problem(in_place.error(), request);
  if (!service.tilesets.CheckCatalogue()) return refuse("The catalogue cannot be read.");
  struct statvfs disk {};
  const bool has_disk = statvfs(service.store.dir().root().c_str(), &disk) == 0;
  if (!has_disk || std::uint64_t{disk.f_bavail} * disk.f_frsize < kMinFreeBytes) {
    return refuse("The disk is full.");
  }
  return Json(200, R"({"status":"ready"})");
}

}  // namespace

void AddOpsRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/healthz", [](const Request&) { return Json(200, R"({"status":"ok"})"); })
      .scope = kEverybody;
  // Not behind what waits for the catalogue.
  router.AddQuick(Method::kGet, "/readyz", [&](const Request& request) { return Ready(service, request); })
      .scope = kEverybody;
  router
      .Add(Method::kGet, "/metrics",
           [&](const Request& request) {
             const Result<storage::JobCounts> jobs = service.queue.Count();
             if (!jobs) return Problem(jobs.error(), request);
             const storage::UnitQueue queue(service.db);
             const auto units = queue.Count(storage::Now());
             if (!units) return Problem(units.error(), request);
             const auto held = queue.Held();
             if (!held) return Problem(held.error(), request);
             const auto aside = storage::WorkersAside(service.db).List();
             if (!aside) return Problem(aside.error(), request);
             return Text(200, service.metrics.Text(*jobs, *units, *aside, *held),
                         "text/plain; version=0.0.4; charset=utf-8");
           })
      .scope = storage::Scope::kAdmin;
  router
      .AddQuick(Method::kGet, "/version",
                [&](const Request&) {
                  return Json(200, JsonObject({{"name", JsonString("skyquilt")},
                                               {"version", JsonString(service.version)}}));
                })
      .scope = kEverybody;
  router
      .AddQuick(Method::kGet, "/openapi.json",
                [](const Request&) { return Text(200, std::string(kOpenApi), "application/json"); })
      .scope = kEverybody;
}

}  // namespace skyquilt::api
