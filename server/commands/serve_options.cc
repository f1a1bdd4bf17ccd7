#include "server/commands/serve_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

#include "api/basemap/basemap.h"
#include "server/commands/config_file.h"
#include "server/routing/origin_policy.h"
#include "server/routing/public_address.h"
#include "server/terminal/fail.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

std::string IsHttpUrl(const std::string& text) {
  const bool is_http = text.starts_with("http://") || text.starts_with("https://");
  return is_http && text.find_first_of(" \"<>?#") == std::string::npos ? ""
                                                                       : "must be an http or https address";
}

// What one client may take of the server, and who counts as one.
void AddBounds(CLI::App& command, ServeOptions& options) {
  constexpr std::size_t kMaxCount = 1'000'000;
  const auto add = [&](const char* name, auto& value, const char* what) {
    return command.add_option(std::string("--") + name, value, what);
  };
  const auto add_number = [&](const char* name, std::size_t& value, std::size_t least, const char* what) {
    add(name, value, what)->check(CLI::Range(least, kMaxCount))->capture_default_str();
  };
  add("trusted-proxy", options.trusted_proxies,
      "Address (or network, as 10.0.0.0/8) of a proxy whose X-Forwarded-For, -Proto, -Host and -Prefix are believed; may be given several times")
      ->delimiter(',');
  add_number("connections-per-address", options.http.connections_of_client, 0,
             "Connections that one client address may hold; 0: no bound");
  add_number("listeners-per-address", options.listeners_per_address, 0,
             "Listeners to events that one client address may have; 0: no bound");
  add_number("requests-per-address", options.http.max_of_client, 0,
             "Requests of one client address that wait or are worked on, of each kind; 0: no bound");
  add_number("waiting-requests", options.http.max_waiting, 1,
             "Requests that wait for a thread, of each kind; more are answered 429");
  add_number("tile-cache-mb", options.tile_cache_mb, 0,
             "Megabytes of memory for tiles in other formats and sizes than they are stored in");
  command.add_flag(
      "--keyed-cache", options.keyed_cache,
      "Tiles that a token opened say \"public\": for a cache in front whose key has Authorization and "
      "the query");
}

}  // namespace

void RefuseUnknownVariables(const CLI::App& command) {
  const std::string prefix = VariableOf("");
  const std::vector<const CLI::Option*> options = command.get_options();
  for (char** variable = environ; *variable != nullptr; ++variable) {
    std::string_view name(*variable);
    name = name.substr(0, name.find('='));
    if (!name.starts_with(prefix)) continue;
    const bool is_known = std::any_of(options.begin(), options.end(), [&](const CLI::Option* option) {
      return option->get_envname() == name;
    });
    if (!is_known) {
      Refuse("skyquilt serve", fmt::format("The variable {} is not known.", name));
    }
  }
}

void AddServeOptions(CLI::App& command, ServeOptions& options) {
  command.add_option("--data", options.data_dir, "Data folder; made when missing")->required();
  AddCatalogueOptions(command, options.catalogue);
  AddBlobOptions(command, options.blobs);
  command.add_option("--listen", options.listen, "ADDRESS:PORT; port 0 picks a free one")
      ->capture_default_str();
  command.add_option("--workers", options.workers, "Worker processes that stitch")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  command
      .add_option("--cut-above", options.cut_above,
                  "Flights of more files than this are cut into parts that several workers share; 0: none is")
      ->check(CLI::Range(0, 1 << 24))
      ->capture_default_str();
  command
      .add_option(
          "--job-timeout", options.job_timeout_s,
          "Seconds after which a job is ended; 0: ten minutes, a minute a file or frame of a film, and a second a MiB")
      ->check(CLI::Range(0, 30 * 24 * 3600))
      ->capture_default_str();
  command
      .add_option("--job-memory", options.job_memory_mib,
                  "MiB of memory beyond which a job is ended; 0: 5 GiB and 2 MiB per file, and no more "
                  "than three quarters of what the machine has")
      ->check(CLI::Range(0, 1 << 24))
      ->capture_default_str();
  command
      .add_option("--photo-timeout", options.photo_timeout_s,
                  "Seconds of processor time that the preview of one photo may take; it is passed over then")
      ->check(CLI::Range(1, 24 * 3600))
      ->capture_default_str();
  command.add_flag("--previews,!--no-previews", options.previews,
                   "Draw flights while they are uploading (default, but with --workers 0)");
  command
      .add_option("--trash-days", options.trash_days,
                  "Days that a deleted flight can be restored; 0 deletes at once and for good")
      ->check(CLI::Range(0, 3650))
      ->capture_default_str();
  command
      .add_option(
          "--keep-days", options.keep_days,
          "Days after which a flight that nobody changes goes to the trash, if it is not shared and no "
          "job or upload of it is open; 0: never")
      ->check(CLI::Range(0, 3650))
      ->capture_default_str();
  command.add_option("--web", options.web_dir, "Folder of the web page, instead of the built-in one");
  command
      .add_option("--public-url", options.http.public_url,
                  "How others reach this server, where a proxy is before it")
      ->check(IsHttpUrl);
  command
      .add_option(
          "--base-path", options.http.base_path,
          "Path that this server lies under at a proxy, as /skyquilt, whether the proxy takes it off or "
          "not")
      ->check([](const std::string& path) {
        return IsBasePath(path) ? ""
                                : "must be a path as /skyquilt or /maps/drone, without a slash at its end";
      });
  command
      .add_option("--webhooks", options.webhooks,
                  "Whom this server may tell of ended jobs: nobody (off), public addresses, or any")
      ->check(OneOf(std::vector<std::string>{"off", "public", "any"}))
      ->capture_default_str();
  command
      .add_option("--node-engine", options.node_engine,
                  "As which engine this node answers WebODM and its relatives; some insist on \"odm\"")
      ->check([](const std::string& name) {
        return api::IsNodeEngine(name) ? "" : "must be lower-case letters and digits, 32 at most";
      })
      ->capture_default_str();
  command.add_option(
      "--basemap", options.basemap,
      fmt::format("What lies below the maps on the page, fetched by each browser from there: {} (read "
                  "their terms of use), https://host/{{z}}/{{x}}/{{y}}.png, a PMTiles file of raster "
                  "tiles here, or none. Default: whoever looks may choose one of these names",
                  fmt::join(api::BasemapNames(), ", ")));
  command.add_option("--basemap-attribution", options.basemap_attribution,
                     "Whom the page names as the makers of the basemap; plain text");
  command.add_flag(
      "--open", options.open,
      "Permit an address that other machines can reach, without any token; lets everybody in again where "
      "the last token was revoked");
  CLI::Option* watched = command.add_option(
      "--watch", options.watched.folders,
      "Folder that fills, or where cards are mounted: what is in it becomes flights, as by \"skyquilt "
      "watch\"; may be given several times");
  command.add_option("--watch-token-file", options.watched.token_file,
                     "File with the token for these flights, where the server asks for one");
  AddBounds(command, options);
  CLI::Option* hosts =
      command
          .add_option(
              "--host", options.http.hosts,
              "A name that the server goes by, besides those of this machine; several, or with commas. Others are "
              "refused once one is named, and always without tokens")
          ->delimiter(',');
  CLI::Option* cors_origins =
      command
          .add_option(
              "--cors-origin", options.http.cors_origins,
              "A site whose pages may use the API: https://host; several, or with commas. Without this, any "
              "with a token, and none where no token is asked for")
          ->delimiter(',')
          ->check([](const std::string& text) {
            return IsOriginText(text) ? std::string()
                                      : "must be an origin as https://host:port, without a path";
          });
  command.add_option("--config", options.config, "File with these options, one \"name = value\" a line");
  for (CLI::Option* option : command.get_options()) {
    if (option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (name != "help" && name != "config") option->envname(VariableOf(name));
    // A file's options come before those of the command line.
    if (name != "trusted-proxy") option->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }
  for (CLI::Option* option : {hosts, cors_origins, watched})
    option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
}

}  // namespace skyquilt::server
