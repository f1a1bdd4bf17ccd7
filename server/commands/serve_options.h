// ServeOptions: what "skyquilt serve" was told, by its command line, variables and file; and how these are
// declared. A value. Errors of what was typed end the process with a sentence (Fail).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "api/events/event_hub.h"
#include "api/nodeodm/nodeodm.h"
#include "server/http/http_server.h"
#include "server/jobs/worker_context.h"
#include "server/usage/storage_options.h"
#include "server/watch/watch_process.h"
#include "storage/tilesets/made_tiles.h"

namespace CLI {
class App;
}

namespace skyquilt::server {

struct ServeOptions {
  std::string data_dir;
  CatalogueOptions catalogue;
  storage::BlobPlace blobs;
  HttpSettings http;  // without what follows from `listen`, from proxies and from this machine
  std::string listen = "127.0.0.1:8080";
  std::string web_dir;
  std::string basemap;
  std::string basemap_attribution;
  std::string webhooks = "off";
  std::string node_engine = api::kUsualNodeEngine;
  WatchedFolders watched;
  std::string config;  // read before the options are (ExpandConfig)
  int workers = 1;
  int trash_days = 30;
  int keep_days = 0;               // 0: for ever
  int cut_above = kCutAboveFiles;  // files of a flight
  int job_timeout_s = 0;
  int job_memory_mib = 0;
  int photo_timeout_s = 60;
  bool previews = true;
  bool open = false;
  bool keyed_cache = false;  // of the operator's, in front, by token
  std::vector<std::string> trusted_proxies;
  std::size_t listeners_per_address = api::EventHub::kUsualMostOfClient;
  std::size_t tile_cache_mb = storage::MadeTiles::kUsualBudgetBytes >> 20;
};

// Each but --config may come from a variable of its name (VariableOf).
void AddServeOptions(CLI::App& command, ServeOptions& options);

// A variable that is misspelt would otherwise do nothing, silently.
void RefuseUnknownVariables(const CLI::App& command);

}  // namespace skyquilt::server
