// Service: everything the handlers work on, owned by the server for as long as it runs. Any thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "api/auth/limits.h"
#include "api/basemap/basemap.h"
#include "api/common/per_revision.h"
#include "api/events/event_hub.h"
#include "api/ops/metrics.h"
#include "api/surface/map_surface.h"
#include "api/tiles/map_bands.h"
#include "api/tiles/tile_facts.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/surface/terrain/height_shift.h"
#include "storage/caches/tileset_cache.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/event_log.h"
#include "storage/catalogue/node_tasks.h"
#include "storage/catalogue/previews.h"
#include "storage/catalogue/tokens.h"
#include "storage/exports/streamed/streamed_maps.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/map_exports.h"
#include "storage/tilesets/made_tiles.h"
#include "storage/uploads/photo_store.h"
#include "storage/uploads/unpack_archive.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::api {

inline constexpr const char* kUsualNodeEngine = "skyquilt";

struct Service {
  storage::Catalogue& catalogue;
  storage::JobQueue& queue;
  storage::PhotoStore& store;
  storage::TilesetCache& tilesets;
  Metrics& metrics;
  storage::CatalogueDb& db;
  std::string version;
  int worker_count = 1;  // that stitch beside this server
  storage::EventLog events{db};
  storage::NodeTasks node_tasks{db};
  storage::UploadSpool spool{db, catalogue, store};
  storage::MapExports exports{db};
  int trash_days = 30;  // that a deleted flight can be restored; 0: not at all
  int keep_days = 0;    // after which a flight that nobody changes goes to the trash; 0: never
  storage::PreviewCache preview_cache{store.dir(), db};
  storage::MadeTiles made_tiles{};
  storage::StreamedMaps streamed_maps{};
  PerRevision<TileFacts> tile_facts{};
  MapBands bands{store.blobs()};
  MapSurfaces surfaces{store.blobs()};
  // Of two maps' heights against each other, as api/surface/change.h finds them.
  PerRevision<std::variant<surface::HeightShift, surface::ShiftFault>> height_shifts{};
  std::mutex height_shifts_mutex{};            // held while one is found
  std::string node_engine = kUsualNodeEngine;  // as which the NodeODM-compatible node answers
  bool sends_webhooks = false;                 // the operator lets this server speak to others
  // To this address, too; asked when one is named, and once more by whoever sends.
  std::function<Result<void>(const std::string& url)> check_receiver = [](const std::string&) {
    return Result<void>();
  };
  // This machine has a program that makes a PDF of a report.
  std::function<bool()> prints_pdf = [] { return false; };
  storage::Tokens tokens{db};
  bool has_keyed_cache = false;  // the operator's cache in front has Authorization and the query in its key
  RateLimiter rate_limiter{};
  ByteLedger quotas{};
  std::mutex once_mutex{};  // held while a request with an Idempotency-Key is carried out
  EventHub event_hub{events, queue};
  std::atomic<bool> is_draining = false;
  // kUnavailable while the data folder is not where and what it was: then nothing may be stored.
  std::function<Result<void>()> storage_in_place = [] { return Result<void>(); };
  // Where other machines reach this server, the likeliest first, as far as who asks from this machine, or
  // from another, is to be told; none: it listens to its own machine alone, or only its operator knows.
  std::function<std::vector<std::string>(bool is_from_this_machine)> addresses_for_others =
      [](bool /*is_from_this_machine*/) { return std::vector<std::string>(); };
  // Lets this network see the server: it listens at the machine's addresses besides, until it ends, and who
  // asks there needs a token (Request::needs_token). Empty: how others reach it is the operator's choice.
  std::function<Result<void>()> open_network = nullptr;
  std::atomic<bool> is_network_open = false;
  Basemap basemap{};
  // What is in these files, as JSON, without making a map; `options`: the flight's, as JSON. Reading them
  // takes a second or two. The server has it done by a process apart, once for each set of files.
  std::function<Result<std::string>(const std::vector<flight::InputFile>&, const std::string& options)>
      inspect = nullptr;
  // A flight's list of surveyed points as JSON (core/pipeline/placing/control_points.h). The server has it
  // done by a process apart.
  std::function<Result<std::string>(const std::filesystem::path& list)> read_control = nullptr;
  // An archive's files into a flight's store, no more than `max_bytes` (kTooLarge beyond). The server has it
  // done by a process apart.
  std::function<Result<std::vector<storage::UnpackedFile>>(
      const storage::PhotoStore&, const std::string& flight_id, const std::filesystem::path& archive,
      std::int64_t max_bytes)>
      unpack =
          [](const auto& photo_store, const auto& flight_id, const auto& archive, std::int64_t max_bytes) {
            return storage::UnpackArchive(photo_store, flight_id, archive, {.room_bytes = max_bytes});
          };
};

}  // namespace skyquilt::api
