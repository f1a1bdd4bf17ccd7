// For operators and monitoring: liveness, readiness, metrics, version, API contract.
#include <sys/statvfs.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "api/http/responses.h"
#include "api/routes.h"
#include "core/base/try.h"

namespace skyquilt::api {

extern const std::string_view kOpenApi;  // api/openapi.json

namespace {

constexpr std::uint64_t kMinFreeBytes = std::uint64_t{64} << 20;

Result<Response> Ready(Service& service) {
  const auto refuse = [](const char* why) { return Error{ErrorCode::kUnavailable, why}; };
  if (service.is_draining) return refuse("The server is shutting down.");
  SKYQUILT_TRY(service.storage_in_place());
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
  router.AddQuick(Method::kGet, "/readyz", [&](const Request&) { return Ready(service); }).scope = kEverybody;
  router
      .Add(Method::kGet, "/metrics",
           [&](const Request&) -> Result<Response> {
             SKYQUILT_TRY_ASSIGN(const storage::JobCounts jobs, service.queue.Count());
             const storage::UnitQueue queue(service.db);
             SKYQUILT_TRY_ASSIGN(const auto units, queue.Count(storage::Now()));
             SKYQUILT_TRY_ASSIGN(const auto held, queue.Held());
             SKYQUILT_TRY_ASSIGN(const auto aside, storage::WorkersAside(service.db).List());
             return Text(200, service.metrics.Text(jobs, units, aside, held),
                         "text/plain; version=0.0.4; charset=utf-8");
           })
      .scope = storage::Scope::kAdmin;
  router
      .AddQuick(Method::kGet, "/version",
                [&](const Request&) {
                  return JsonOf(200, {{"name", "skyquilt"}, {"version", service.version}});
                })
      .scope = kEverybody;
  router
      .AddQuick(Method::kGet, "/openapi.json",
                [](const Request&) { return Text(200, std::string(kOpenApi), "application/json"); })
      .scope = kEverybody;
}

}  // namespace skyquilt::api
