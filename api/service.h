// Service: everything the handlers work on, owned by the server for as long as it runs. Any thread.
#pragma once

#include <atomic>
#include <string>

#include "api/ops/metrics.h"
#include "storage/catalogue.h"
#include "storage/job_queue.h"
#include "storage/photo_store.h"
#include "storage/tileset_cache.h"

namespace skyquilt::api {

struct Service {
  storage::Catalogue& catalogue;
  storage::JobQueue& queue;
  storage::PhotoStore& store;
  storage::TilesetCache& tilesets;
  Metrics& metrics;
  std::string version;
  std::atomic<bool> is_draining = false;
};

}  // namespace skyquilt::api
