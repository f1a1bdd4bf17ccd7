#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "api/build_api.h"
#include "api/uploads/tus_chunk.h"
#include "api/uploads/unpack.h"
#include "core/base/process/late_library.h"
#include "core/base/text/plain_text.h"
#include "core/base/text/printable.h"
#include "server/commands/commands.h"
#include "server/commands/serve_options.h"
#include "server/exports/export_runner.h"
#include "server/housekeeper.h"
#include "server/http/http_server.h"
#include "server/intake/archive_unpacker.h"
#include "server/intake/unpack_sandboxed.h"
#include "server/intake/verdict_sandboxed.h"
#include "server/intake/verdicts.h"
#include "server/open_storage.h"
#include "server/reports/print_pdf.h"
#include "server/routing/address_range.h"
#include "server/routing/network_addresses.h"
#include "server/routing/request_log.h"
#include "server/routing/static_files.h"
#include "server/sandbox/run_sandboxed.h"
#include "server/sandbox/sandbox.h"
#include "server/terminal/fail.h"
#include "server/usage/storage_options.h"
#include "server/webhooks/post_message.h"
#include "server/webhooks/webhook_sender.h"
#include "server/workers/worker_pool.h"
#include "storage/db/sqlite_db.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {
namespace {

// From the signal to stop: what is under way may end, then connections are cut and workers killed, and at the
// last the process ends whatever it computes. Supervisors kill after ten seconds or more.
constexpr std::chrono::milliseconds kDrainTime{7'000};
constexpr std::chrono::milliseconds kWorkerGrace{7'000};
constexpr std::chrono::milliseconds kWatchGrace{1'000};
constexpr std::chrono::milliseconds kStopTime{9'000};
// Connections that read the catalogue. A read takes microseconds: a thread that finds none idle waits for
// one.
constexpr int kReaders = 8;
constexpr int kTileReaders = 4;
constexpr timespec kSupervisionInterval{0, 500'000'000};

// "https://maps.example.org:8443/x" -> "maps.example.org:8443"
std::string HostOf(const std::string& url) {
  const std::size_t host = url.find("://") + 3;
  return url.substr(host, url.find('/', host) - host);
}

// "127.0.0.1:8080", "localhost:0", "[::1]:8080".
Result<HttpSettings> SettingsFrom(const ServeOptions& options, bool has_tokens) {
  const std::string& text = options.listen;
  const std::size_t colon = text.rfind(':');
  const Error bad{ErrorCode::kInvalidArgument, fmt::format("--listen {}: give it as ADDRESS:PORT.", text)};
  if (colon == std::string::npos) return bad;
  std::string address = text.substr(0, colon);
  if (address.starts_with('[') && address.ends_with(']')) address = address.substr(1, address.size() - 2);
  if (address == "localhost") address = "127.0.0.1";
  HttpSettings settings = options.http;
  const auto port = ParseNumber<std::uint16_t>(std::string_view(text).substr(colon + 1));
  if (!port || address.empty()) return bad;
  settings.port = *port;
  if (!IsLoopback(address) && !options.open && !has_tokens) {
    return Error{
        ErrorCode::kForbidden,
        fmt::format(
            "{} can be reached by others, who could upload and delete. Make a token with \"skyquilt token "
            "add\", or add --open if that is what you want.",
            address)};
  }
  settings.address = address;
  while (settings.public_url.ends_with('/')) settings.public_url.pop_back();
  settings.always_checks_host = !settings.hosts.empty();
  if (!settings.public_url.empty()) settings.hosts.push_back(HostOf(settings.public_url));
  settings.threads = std::max(2, static_cast<int>(std::thread::hardware_concurrency()));
  settings.compute_threads = settings.threads;
  for (const std::string& proxy : options.trusted_proxies) {
    const std::optional<AddressRange> range = AddressRange::From(proxy);
    if (!range) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format(
              "--trusted-proxy {}: give it as an IP address or a network, such as 127.0.0.1 or 10.0.0.0/8.",
              proxy)};
    }
    settings.trusted_proxies.push_back(*range);
  }
  return settings;
}

// And the operator said nothing of names and proxies by which others reach it.
bool IsForThisMachineAlone(const HttpSettings& settings) {
  return IsLoopback(settings.address) && settings.public_url.empty() && settings.hosts.empty() &&
         settings.trusted_proxies.empty();
}

// How this machine reaches the server.
std::string OwnUrl(const HttpSettings& settings, int port) {
  std::string host = settings.address;
  if (host == "0.0.0.0") host = "127.0.0.1";
  if (host == "::") host = "::1";
  return fmt::format("http://{}:{}{}", HostInUrl(host), port, settings.base_path);
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
void SuperviseWorkers(WorkerPool& workers, WatchProcess& watching, const storage::DataDirWatch& watch,
                      const sigset_t& signals) {
  bool was_in_place = true;
  while (true) {
    const Result<void> in_place = watch.Check();
    if (in_place.ok() != was_in_place) {
      LogEvent(in_place ? "the data folder is back: the server goes on" : in_place.error().message);
      if (!in_place) workers.Interrupt();
      was_in_place = in_place.ok();
    }
    if (in_place) workers.StartMissing();
    if (in_place) watching.StartMissing();
    const int number = sigtimedwait(&signals, nullptr, &kSupervisionInterval);
    if (number == SIGTERM || number == SIGINT || number == SIGHUP) return;
    workers.Reap();
    watching.Reap();
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
  const storage::TokenSet set = OrFail("skyquilt serve", tokens.Read());
  if (!set.requires_token || set.HasLiveOne(storage::Now())) return set.requires_token;
  if (!is_open) {
    LogEvent("all tokens were revoked or have ended: nobody gets in until one is made or --open is said");
    return true;
  }
  OrFail("skyquilt serve", tokens.LetEverybodyIn());
  return false;
}

// Resumable uploads that were complete when an earlier run ended.
void FinishUploads(api::Service& service) {
  const std::vector<storage::SpooledUpload> finished =
      OrFail("skyquilt serve", service.spool.FinishComplete(service.db.ages().Now()));
  for (const storage::SpooledUpload& upload : finished) {
    const Result<void> unpacked = api::UnpackUpload(service, upload);
    if (!unpacked) LogFailure(upload.id, "unpack", unpacked.error());
  }
}

// By default the C library gives memory back to the system after every tile and asks for it again at the
// next. Setting one threshold keeps it from adapting the other, so that both are set: a tile's planes are no
// blocks of their own, whose pages the kernel would clear for every tile (half the cost of an index tile).
void KeepFreedMemory() {
  constexpr int kOwnBlockAbove = 8 << 20, kTrimAbove = 8 << 20;
  mallopt(M_MMAP_THRESHOLD, kOwnBlockAbove);
  mallopt(M_TRIM_THRESHOLD, kTrimAbove);
}

void RunServer(const ServeOptions& options) {
  if (options.keep_days > 0 && options.trash_days == 0) {
    Refuse(
        "skyquilt serve",
        "--keep-days puts flights that nobody changes into the trash, and with --trash-days 0 there is none. "
        "Give --trash-days 1 or more, or leave --keep-days out.");
  }
  const sigset_t signals = BlockSignals();
  RaiseDescriptorLimit();
  storage::SqliteDb::CountNoMemory();
  OrFail("skyquilt serve", TryLate());  // a library that is missing is no surprise of the first request
  KeepFreedMemory();
  const storage::CataloguePlace given = PlaceOf("skyquilt serve", options.catalogue);
  const std::vector<std::string> catalogue_words = WordsOfPlace(given);
  // The store is looked at before anything is made beside it.
  const storage::CataloguePlace place = OrFail("skyquilt serve", storage::WithFilesAt(given, options.blobs));
  Storage opened = OrFail("skyquilt serve", OpenStorage(options.data_dir, kReaders, kTileReaders, place));
  const std::shared_ptr<storage::BlobStore> blobs =
      OrFail("skyquilt serve", OpenBlobsOf(opened.dir, *opened.db, options.blobs));
  if (!blobs->IsFolder()) LogEvent("photos and maps lie at " + blobs->Address());
  const bool requires_token = RequiresToken(*opened.db, options.open);
  const HttpSettings settings = OrFail("skyquilt serve", SettingsFrom(options, requires_token));
  OrFail("skyquilt serve", CheckWatched(options.watched, opened.dir.root(), requires_token));
  // A folder of one machine among many holds no flights: backups of the database stand for the records.
  std::optional<storage::FlightRecords> records;
  if (!place.IsOfManyFolders()) {
    const int written = OrFail("skyquilt serve", storage::WriteMissingRecords(opened.dir, *opened.db));
    if (written > 0)
      LogEvent(
          fmt::format("{} of an earlier version got a record, flight.jsonl", Counted(written, "flight")));
    OrFail("skyquilt serve", storage::SettleRecords(opened.dir, *opened.db));
    records.emplace(opened.dir);
  }
  storage::Catalogue catalogue(*opened.db, std::move(records));
  storage::Catalogue tiles_catalogue(*opened.tiles_db);
  storage::JobQueue queue(*opened.db);
  storage::PhotoStore store(opened.dir, blobs);
  storage::TilesetCache tilesets(opened.dir, tiles_catalogue, blobs, given.IsPostgres());
  api::Metrics metrics;
  api::Service service{catalogue,        queue,          store, tilesets, metrics, *opened.db,
                       SKYQUILT_VERSION, options.workers};
  Verdicts verdicts(VerdictSandboxed);
  service.inspect = [&verdicts](const std::vector<flight::InputFile>& files,
                                const std::string& mosaic_options) {
    return verdicts.Of(files, mosaic_options);
  };
  service.unpack = UnpackSandboxed;
  service.read_control = ControlSandboxed;
  service.storage_in_place = [&opened] { return opened.watch.Check(); };
  OrFail("skyquilt serve", Recover(opened.dir, catalogue, queue, storage::Previews(*opened.db), service.spool,
                                   service.db.ages().Now()));
  OrFail("skyquilt serve", RecoverExports(service));
  service.made_tiles.SetBudget(options.tile_cache_mb << 20);
  service.event_hub.SetMostOfClient(options.listeners_per_address);
  FinishUploads(service);
  // Of a shared catalogue another server may be unpacking one at this moment.
  std::vector<api::CutOffArchive> cut_off;
  if (!service.db.IsShared()) cut_off = OrFail("skyquilt serve", api::FindCutOff(service));
  const api::Basemap basemap =
      OrFail("skyquilt serve", api::BasemapFrom(options.basemap, options.basemap_attribution));
  service.basemap = basemap;
  service.trash_days = options.trash_days;
  service.keep_days = options.keep_days;
  service.has_keyed_cache = options.keyed_cache;
  service.node_engine = options.node_engine;
  service.sends_webhooks = options.webhooks != "off";
  if (options.webhooks == "public") service.check_receiver = CheckReceiver;
  service.prints_pdf = CanPrintPdf;
  api::Router router = api::BuildApi(service);
  const std::optional<std::filesystem::path> page = FindPageFolder(options.web_dir);
  if (!page && !options.web_dir.empty()) {
    Fail("skyquilt serve", {ErrorCode::kNotFound, "--web " + options.web_dir + " has no index.html."});
  }
  router.SetFallback([page, origin = basemap.Origins()](const api::Request& request) {
    return page ? ServePage(*page, request, origin) : NoPage(request);
  });
  const std::unique_ptr<HttpServer> server =
      OrFail("skyquilt serve", HttpServer::Listen(settings, router, service));
  service.addresses_for_others = [&settings, &server = *server](bool is_from_this_machine) {
    std::vector<std::string> addresses = AddressesForOthers(settings, server.port(), is_from_this_machine);
    return addresses.empty() ? server.NetworkAddresses() : addresses;
  };
  if (IsForThisMachineAlone(settings))
    service.open_network = [&server = *server] { return server.OpenNetwork(); };
  server->Start();
  fmt::print("Skyquilt is serving at http://{}:{}{}/\n", HostInUrl(settings.address), server->port(),
             settings.base_path);
  std::fflush(stdout);

  const Housekeeper housekeeper(service);
  const ArchiveUnpacker unpacker(service, std::move(cut_off));
  const ExportRunner export_runner(service);
  std::optional<WebhookSender> sender;
  if (service.sends_webhooks) sender.emplace(service, options.webhooks == "any");
  LogEvent("what others made is decoded under " + ConfinementHere());
  storage::UnitQueue units(*opened.db);
  std::vector<std::string> words = {"--job-timeout",   std::to_string(options.job_timeout_s),
                                    "--job-memory",    std::to_string(options.job_memory_mib),
                                    "--photo-timeout", std::to_string(options.photo_timeout_s),
                                    "--cut-above",     std::to_string(options.cut_above)};
  const std::vector<std::string> blob_words = BlobWords(options.blobs);
  words.insert(words.end(), blob_words.begin(), blob_words.end());
  words.insert(words.end(), catalogue_words.begin(), catalogue_words.end());
  WorkerPool workers(opened.dir, options.workers, options.previews, queue, units, std::move(words));
  WatchProcess watching(WatchWords(options.watched, opened.dir.root(), OwnUrl(settings, server->port())));
  SuperviseWorkers(workers, watching, opened.watch, signals);
  fmt::print("Skyquilt is stopping.\n");
  std::fflush(stdout);
  const auto deadline = std::chrono::steady_clock::now() + kStopTime;
  ExitAt(deadline);
  std::thread draining([&server = *server] {
    if (!server.Drain(kDrainTime)) LogEvent("some connections did not finish in time and were cut");
    EndAllSandboxed();
  });
  watching.Stop(kWatchGrace);
  workers.Stop(kWorkerGrace);
  draining.join();
  if (!server->End(deadline)) ExitNow();
}

}  // namespace

void AddServeCommand(CLI::App& app) {
  const auto options = std::make_shared<ServeOptions>();
  CLI::App* command =
      app.add_subcommand("serve", "Serve the web page, the API and the tiles, and stitch uploads");
  AddServeOptions(*command, *options);
  command->callback([options, command] {
    RefuseUnknownVariables(*command);
    if (options->workers == 0 && command->count("--previews") == 0) options->previews = false;
    RunServer(*options);
  });
}

}  // namespace skyquilt::server
