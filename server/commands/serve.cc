#include "server/commands/serve.h"

#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "api/build_api.h"
#include "api/nodeodm/nodeodm.h"
#include "api/uploads/unpack.h"
#include "server/commands/config_file.h"
#include "server/commands/fail.h"
#include "server/confinement/run_apart.h"
#include "server/confinement/sandbox.h"
#include "server/housekeeper.h"
#include "server/http/http_server.h"
#include "server/intake/unpack_apart.h"
#include "server/intake/verdict_apart.h"
#include "server/intake/verdicts.h"
#include "server/jobs/worker_pool.h"
#include "server/open_storage.h"
#include "server/routing/address_range.h"
#include "server/routing/origin_policy.h"
#include "server/routing/request_log.h"
#include "server/routing/static_files.h"
#include "server/webhooks/webhook_sender.h"

namespace skyquilt::server {
namespace {

// From the signal to stop: what is under way may end, then connections are cut and workers killed, and at the
// last the process ends whatever it computes. Supervisors kill after ten seconds or more.
constexpr std::chrono::milliseconds kDrainTime{7'000};
constexpr std::chrono::milliseconds kWorkerGrace{7'000};
constexpr std::chrono::milliseconds kStopTime{9'000};
// Connections that read the catalogue. A read takes microseconds: a thread that finds none idle waits for
// one.
constexpr int kReaders = 8;
constexpr int kTileReaders = 4;
constexpr timespec kSupervisionInterval{0, 500'000'000};

struct ServeOptions {
  std::string data_dir;
  std::string listen = "127.0.0.1:8080";
  std::string web_dir;
  std::string public_url;
  std::string basemap;
  std::string basemap_attribution;
  std::string webhooks = "off";
  std::string node_engine = api::kUsualNodeEngine;
  std::vector<std::string> hosts;
  std::vector<std::string> cors_origins;
  std::string config;  // read before the options are (ExpandConfig)
  int workers = 1;
  int trash_days = 30;
  int job_timeout_s = 0;
  int job_memory_mib = 0;
  int photo_timeout_s = 60;
  bool previews = true;
  bool open = false;
  std::vector<std::string> trusted_proxies;
  std::size_t connections_per_address = HttpSettings().connections_of_client;
  std::size_t listeners_per_address = api::EventHub::kUsualMostOfClient;
  std::size_t requests_per_address = HttpSettings().max_of_client;
  std::size_t waiting_requests = HttpSettings().max_waiting;
  std::size_t tile_cache_mb = storage::MadeTiles::kUsualBudgetBytes >> 20;
};

// "https://maps.example.org:8443/x" -> "maps.example.org:8443"
std::string HostOf(const std::string& url) {
  const std::size_t host = url.find("://") + 3;
  return url.substr(host, url.find('/', host) - host);
}

// "127.0.0.1:8080", "localhost:0", "[::1]:8080".
Result<HttpSettings> SettingsFrom(const ServeOptions& options, bool has_tokens) {
  const std::string& text = options.listen;
  const std::size_t colon = text.rfind(':');
  const Error bad{ErrorCode::kInvalidArgument, fmt::format("--listen {}: give it as ADDRESS:PORT.", text),
                  ""};
  if (colon == std::string::npos) return bad;
  std::string address = text.substr(0, colon);
  if (address.starts_with('[') && address.ends_with(']')) address = address.substr(1, address.size() - 2);
  if (address == "localhost") address = "127.0.0.1";
  HttpSettings settings;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + colon + 1, end, settings.port);
  if (parsed.ec != std::errc() || parsed.ptr != end || address.empty()) return bad;
  const bool is_loopback = address.starts_with("127.") || address == "::1";
  if (!is_loopback && !options.open && !has_tokens) {
    return Error{
        ErrorCode::kForbidden,
        fmt::format(
            "{} can be reached by others, who could upload and delete. Make a token with \"skyquilt token "
            "add\", or add --open if that is what you want.",
            address),
        ""};
  }
  settings.address = address;
  settings.public_url = options.public_url;
  while (settings.public_url.ends_with('/')) settings.public_url.pop_back();
  settings.hosts = options.hosts;
  settings.always_checks_host = !options.hosts.empty();
  if (!settings.public_url.empty()) settings.hosts.push_back(HostOf(settings.public_url));
  settings.cors_origins = options.cors_origins;
  settings.threads = std::max(2, static_cast<int>(std::thread::hardware_concurrency()));
  settings.compute_threads = settings.threads;
  settings.connections_of_client = options.connections_per_address;
  settings.max_of_client = options.requests_per_address;
  settings.max_waiting = options.waiting_requests;
  for (const std::string& proxy : options.trusted_proxies) {
    const std::optional<AddressRange> range = AddressRange::From(proxy);
    if (!range) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format(
              "--trusted-proxy {}: give it as an IP address or a network, such as 127.0.0.1 or 10.0.0.0/8.",
              proxy),
          ""};
    }
    settings.trusted_proxies.push_back(*range);
  }
  return settings;
}

// Many connections need many descriptors.
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

// Blocked in every thread, so that the main thread takes them one by one and no handler is needed.
sigset_t BlockSignals() {
  signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGTERM, SIGINT, SIGHUP, SIGCHLD}) sigaddset(&signals, number);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Until a signal stops it: workers that ended are collected and started again, but not while the data folder
// is gone: then the running ones are stopped and their jobs return to the queue.
void SuperviseWorkers(WorkerPool& workers, const storage::DataDirWatch& watch, const sigset_t& signals) {
  bool was_in_place = true;
  while (true) {
    const Result<void> in_place = watch.Check();
    if (in_place.ok() != was_in_place) {
      LogEvent(in_place ? "the data folder is back: the server goes on" : in_place.error().message);
      if (!in_place) workers.Interrupt();
      was_in_place = in_place.ok();
    }
    if (in_place) workers.StartMissing();
    const int number = sigtimedwait(&signals, nullptr, &kSupervisionInterval);
    if (number == SIGTERM || number == SIGINT || number == SIGHUP) return;
    workers.Reap();
  }
}

// What handlers use is not destroyed under them; accepted data is on the disk already.
[[noreturn]] void ExitNow() {
  LogEvent("something did not end in time; the process ends without it");
  std::fflush(stdout);
  _exit(0);
}

// Whatever hangs: a library in a handler, a webhook, or the waiting for either.
void ExitAt(std::chrono::steady_clock::time_point deadline) {
  std::thread([deadline] {
    std::this_thread::sleep_until(deadline);
    ExitNow();
  }).detach();
}

api::Response NoPage(const api::Request& request) {
  api::Response response;
  response.status = request.path == "/" ? 200 : 404;
  response.headers.Add("Content-Type", "text/plain; charset=utf-8");
  response.body = "Skyquilt is running. The web page is not installed; the API is at /api/v1/flights.\n";
  return response;
}

// Once there was a token, the server requires one; only --open, where none is left, admits everybody again.
bool RequiresToken(storage::CatalogueDb& db, bool is_open) {
  storage::Tokens tokens(db);
  const Result<storage::TokenSet> set = tokens.Read();
  if (!set) Fail("skyquilt serve", set.error());
  if (!set->requires_token || set->HasLiveOne(storage::Now())) return set->requires_token;
  if (!is_open) {
    LogEvent("all tokens were revoked or have ended: nobody gets in until one is made or --open is said");
    return true;
  }
  const Result<void> opened = tokens.LetEverybodyIn();
  if (!opened) Fail("skyquilt serve", opened.error());
  return false;
}

// Resumable uploads that were complete when an earlier run ended.
void FinishUploads(api::Service& service) {
  const Result<std::vector<storage::SpooledUpload>> finished =
      service.spool.FinishComplete(service.db.ages().Now());
  if (!finished) Fail("skyquilt serve", finished.error());
  for (const storage::SpooledUpload& upload : *finished) {
    const auto unpacked = api::UnpackStored(service, upload.flight_id, *upload.file);
    if (!unpacked) LogFailure(upload.id, "unpack", unpacked.error().message);
  }
}

// By default the C library gives memory back to the system after every tile and asks for it again at the
// next: a tenth of a tile's cost.
void KeepFreedMemory() {
  constexpr int kTrimAbove = 8 << 20;
  mallopt(M_TRIM_THRESHOLD, kTrimAbove);
}

void RunServer(const ServeOptions& options) {
  const sigset_t signals = BlockSignals();
  RaiseDescriptorLimit();
  KeepFreedMemory();
  Result<Storage> storage = OpenStorage(options.data_dir, kReaders, kTileReaders);
  if (!storage) Fail("skyquilt serve", storage.error());
  Storage& opened = *storage;
  const bool requires_token = RequiresToken(*opened.db, options.open);
  const Result<HttpSettings> settings = SettingsFrom(options, requires_token);
  if (!settings) Fail("skyquilt serve", settings.error());
  storage::Catalogue catalogue(*opened.db, storage::FlightRecords(opened.dir));
  storage::Catalogue tiles_catalogue(*opened.tiles_db);
  storage::JobQueue queue(*opened.db);
  storage::PhotoStore store(opened.dir);
  storage::TilesetCache tilesets(opened.dir, tiles_catalogue);
  api::Metrics metrics;
  api::Service service{catalogue,        queue,          store, tilesets, metrics, *opened.db,
                       SKYQUILT_VERSION, options.workers};
  Verdicts verdicts(VerdictApart);
  service.inspect = [&verdicts](const std::vector<flight::InputFile>& files,
                                const std::string& mosaic_options) {
    return verdicts.Of(files, mosaic_options);
  };
  service.unpack = UnpackApart;
  service.storage_in_place = [&opened] { return opened.watch.Check(); };
  const Result<void> recovered = Recover(opened.dir, catalogue, queue, storage::Previews(*opened.db),
                                         service.spool, service.db.ages().Now());
  if (!recovered) Fail("skyquilt serve", recovered.error());
  service.made_tiles.SetBudget(options.tile_cache_mb << 20);
  service.event_hub.SetMostOfClient(options.listeners_per_address);
  FinishUploads(service);
  const Result<api::Basemap> basemap = api::BasemapFrom(options.basemap, options.basemap_attribution);
  if (!basemap) Fail("skyquilt serve", basemap.error());
  service.basemap = *basemap;
  service.trash_days = options.trash_days;
  service.node_engine = options.node_engine;
  service.sends_webhooks = options.webhooks != "off";
  api::Router router = api::BuildApi(service);
  const std::optional<std::filesystem::path> page = FindPageFolder(options.web_dir);
  if (!page && !options.web_dir.empty()) {
    Fail("skyquilt serve", {ErrorCode::kNotFound, "--web " + options.web_dir + " has no index.html.", ""});
  }
  router.SetFallback([page, origin = basemap->Origin()](const api::Request& request) {
    return page ? ServePage(*page, request, origin) : NoPage(request);
  });
  Result<std::unique_ptr<HttpServer>> server = HttpServer::Listen(*settings, router, service);
  if (!server) Fail("skyquilt serve", server.error());
  (*server)->Start();
  const std::string host =
      settings->address.find(':') == std::string::npos ? settings->address : "[" + settings->address + "]";
  fmt::print("Skyquilt is serving at http://{}:{}/\n", host, (*server)->port());
  std::fflush(stdout);

  const Housekeeper housekeeper(service);
  std::optional<WebhookSender> sender;
  if (service.sends_webhooks) sender.emplace(service, options.webhooks == "any");
  LogEvent("what others made is decoded under " + ConfinementHere());
  WorkerPool workers(
      opened.dir, options.workers, options.previews && options.workers > 0, queue,
      {"--job-timeout", std::to_string(options.job_timeout_s), "--job-memory",
       std::to_string(options.job_memory_mib), "--photo-timeout", std::to_string(options.photo_timeout_s)});
  SuperviseWorkers(workers, opened.watch, signals);
  fmt::print("Skyquilt is stopping.\n");
  std::fflush(stdout);
  const auto deadline = std::chrono::steady_clock::now() + kStopTime;
  ExitAt(deadline);
  std::thread draining([&server = **server] {
    if (!server.Drain(kDrainTime)) LogEvent("some connections did not finish in time and were cut");
    EndAllApart();
  });
  workers.Stop(kWorkerGrace);
  draining.join();
  if (!(*server)->End(deadline)) ExitNow();
}

std::string IsHttpUrl(const std::string& text) {
  const bool is_http = text.starts_with("http://") || text.starts_with("https://");
  return is_http && text.find_first_of(" \"<>?#") == std::string::npos ? ""
                                                                       : "must be an http or https address";
}

// A variable that is misspelt would otherwise do nothing, silently.
void RefuseUnknownVariables() {
  const std::string prefix = VariableOf("");
  constexpr std::string_view kOptions[] = {"data",
                                           "listen",
                                           "workers",
                                           "previews",
                                           "job-timeout",
                                           "job-memory",
                                           "photo-timeout",
                                           "web",
                                           "public-url",
                                           "basemap",
                                           "basemap-attribution",
                                           "webhooks",
                                           "node-engine",
                                           "open",
                                           "trusted-proxy",
                                           "connections-per-address",
                                           "listeners-per-address",
                                           "requests-per-address",
                                           "waiting-requests",
                                           "tile-cache-mb",
                                           "trash-days",
                                           "host",
                                           "cors-origin"};
  for (char** variable = environ; *variable != nullptr; ++variable) {
    std::string_view name(*variable);
    name = name.substr(0, name.find('='));
    if (!name.starts_with(prefix)) continue;
    const bool is_known = std::any_of(std::begin(kOptions), std::end(kOptions),
                                      [&](std::string_view option) { return VariableOf(option) == name; });
    if (!is_known) {
      Fail("skyquilt serve",
           {ErrorCode::kInvalidArgument, fmt::format("The variable {} is not known.", name), ""});
    }
  }
}

// What one client may take of the server, and who counts as one.
void AddBounds(CLI::App& command, ServeOptions& options) {
  constexpr std::size_t kMaxCount = 1'000'000;
  const auto add = [&](const char* name, auto& value, const char* what) {
    return command.add_option(std::string("--") + name, value, what)->envname(VariableOf(name));
  };
  const auto add_number = [&](const char* name, std::size_t& value, std::size_t least, const char* what) {
    add(name, value, what)->check(CLI::Range(least, kMaxCount))->capture_default_str();
  };
  add("trusted-proxy", options.trusted_proxies,
      "Address (or network, as 10.0.0.0/8) of a proxy whose X-Forwarded-For says who the client is; may be given several times")
      ->delimiter(',');
  add_number("connections-per-address", options.connections_per_address, 0,
             "Connections that one client address may hold; 0: no bound");
  add_number("listeners-per-address", options.listeners_per_address, 0,
             "Listeners to events that one client address may have; 0: no bound");
  add_number("requests-per-address", options.requests_per_address, 0,
             "Requests of one client address that wait or are worked on, of each kind; 0: no bound");
  add_number("waiting-requests", options.waiting_requests, 1,
             "Requests that wait for a thread, of each kind; more are answered 429");
  add_number("tile-cache-mb", options.tile_cache_mb, 0,
             "Megabytes of memory for tiles in other formats and sizes than they are stored in");
}

}  // namespace

void AddServeCommand(CLI::App& app) {
  const auto options = std::make_shared<ServeOptions>();
  CLI::App* command =
      app.add_subcommand("serve", "Serve the web page, the API and the tiles, and stitch uploads");
  command->add_option("--data", options->data_dir, "Data folder; made when missing")
      ->required()
      ->envname(VariableOf("data"));
  command->add_option("--listen", options->listen, "ADDRESS:PORT; port 0 picks a free one")
      ->envname(VariableOf("listen"))
      ->capture_default_str();
  command->add_option("--workers", options->workers, "Worker processes that stitch")
      ->check(CLI::Range(0, 64))
      ->envname(VariableOf("workers"))
      ->capture_default_str();
  command
      ->add_option("--job-timeout", options->job_timeout_s,
                   "Seconds after which a job is ended; 0: ten minutes, a minute a file and a second a MiB")
      ->check(CLI::Range(0, 30 * 24 * 3600))
      ->envname(VariableOf("job-timeout"))
      ->capture_default_str();
  command
      ->add_option("--job-memory", options->job_memory_mib,
                   "MiB of memory beyond which a job is ended; 0: 5 GiB and 2 MiB per file, and no more "
                   "than three quarters of what the machine has")
      ->check(CLI::Range(0, 1 << 24))
      ->envname(VariableOf("job-memory"))
      ->capture_default_str();
  command
      ->add_option("--photo-timeout", options->photo_timeout_s,
                   "Seconds of processor time that the preview of one photo may take; it is passed over then")
      ->check(CLI::Range(1, 24 * 3600))
      ->envname(VariableOf("photo-timeout"))
      ->capture_default_str();
  command
      ->add_flag("--previews,!--no-previews", options->previews,
                 "Draw flights while they are uploading (default)")
      ->envname(VariableOf("previews"));
  command
      ->add_option("--trash-days", options->trash_days,
                   "Days that a deleted flight can be restored; 0 deletes at once and for good")
      ->check(CLI::Range(0, 3650))
      ->envname(VariableOf("trash-days"))
      ->capture_default_str();
  command->add_option("--web", options->web_dir, "Folder of the web page, instead of the built-in one")
      ->envname(VariableOf("web"));
  command
      ->add_option("--public-url", options->public_url,
                   "How others reach this server, where a proxy is before it")
      ->check(IsHttpUrl)
      ->envname(VariableOf("public-url"));
  command
      ->add_option("--webhooks", options->webhooks,
                   "Whom this server may tell of ended jobs: nobody (off), public addresses, or any")
      ->check(CLI::IsMember({"off", "public", "any"}))
      ->envname(VariableOf("webhooks"))
      ->capture_default_str();
  command
      ->add_option("--node-engine", options->node_engine,
                   "As which engine this node answers WebODM and its relatives; some insist on \"odm\"")
      ->check([](const std::string& name) {
        return api::IsNodeEngine(name) ? "" : "must be lower-case letters and digits, 32 at most";
      })
      ->envname(VariableOf("node-engine"))
      ->capture_default_str();
  command
      ->add_option("--basemap", options->basemap,
                   "What lies below the maps on the page: https://host/{z}/{x}/{y}.png, or a PMTiles file "
                   "of raster tiles")
      ->envname(VariableOf("basemap"));
  command
      ->add_option("--basemap-attribution", options->basemap_attribution,
                   "Whom the page names as the makers of the basemap; plain text")
      ->envname(VariableOf("basemap-attribution"));
  command
      ->add_flag(
          "--open", options->open,
          "Permit an address that other machines can reach, without any token; lets everybody in again where "
          "the last token was revoked")
      ->envname(VariableOf("open"));
  AddBounds(*command, *options);
  CLI::Option* hosts =
      command
          ->add_option(
              "--host", options->hosts,
              "A name that the server goes by, besides those of this machine; several, or with commas. Without "
              "tokens no other is answered")
          ->delimiter(',')
          ->envname(VariableOf("host"));
  CLI::Option* cors_origins =
      command
          ->add_option(
              "--cors-origin", options->cors_origins,
              "A site whose pages may use the API: https://host; several, or with commas. Without this, any "
              "with a token, and none where no token is asked for")
          ->delimiter(',')
          ->check([](const std::string& text) {
            return IsOriginText(text) ? std::string()
                                      : "must be an origin as https://host:port, without a path";
          })
          ->envname(VariableOf("cors-origin"));
  command->add_option("--config", options->config, "File with these options, one \"name = value\" a line");
  // A file's options come before those of the command line.
  for (CLI::Option* option : command->get_options()) {
    if (option->check_name("--trusted-proxy")) continue;
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }
  for (CLI::Option* option : {hosts, cors_origins})
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
  command->callback([options] {
    RefuseUnknownVariables();
    RunServer(*options);
  });
}

}  // namespace skyquilt::server
