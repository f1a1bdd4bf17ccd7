#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "api/auth/access.h"
#include "api/json/json_codec.h"
#include "server/commands/commands.h"
#include "server/terminal/fail.h"
#include "server/usage/option_values.h"
#include "server/usage/storage_options.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/tokens.h"
#include "storage/db/ids.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {
namespace {

struct TokenOptions {
  std::string data_dir;
  CatalogueOptions catalogue;
  storage::BlobPlace blobs;  // for a new folder beside a catalogue whose photos lie in a store
  std::string name;
  std::string scope = "read";
  std::string flight;           // the one that it opens; empty: every flight
  std::string expires;          // "30d"; empty: by `days`
  int days = 0;                 // 0: for ever
  double max_gb = 0.0;          // 0: no limit
  int requests_per_minute = 0;  // 0: no limit
};

std::unique_ptr<storage::CatalogueDb> OpenCatalogue(const TokenOptions& options) {
  const storage::CataloguePlace given = PlaceOf("skyquilt token", options.catalogue);
  const storage::CataloguePlace place = OrFail("skyquilt token", storage::WithFilesAt(given, options.blobs));
  storage::OpenedDataFolder opened =
      OrFail("skyquilt token", storage::OpenOrJoinDataFolder(options.data_dir, place));
  return std::move(opened.db);
}

// "90s", "30m", "12h", "30d", "8w".
std::optional<std::chrono::seconds> ParseDuration(const std::string& text) {
  std::int64_t number = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, number);
  constexpr std::int64_t kMaxUnits = 100'000;  // of any unit
  if (parsed.ec != std::errc() || parsed.ptr + 1 != end || number < 1 || number > kMaxUnits)
    return std::nullopt;
  constexpr std::pair<char, std::int64_t> kSecondsOf[] = {
      {'s', 1}, {'m', 60}, {'h', 3600}, {'d', 24 * 3600}, {'w', 7 * 24 * 3600}};
  for (const auto& [unit, seconds] : kSecondsOf) {
    if (*parsed.ptr == unit) return std::chrono::seconds(seconds * number);
  }
  return std::nullopt;
}

void RequireFlight(storage::CatalogueDb& db, const std::string& id) {
  const bool known = OrFail("skyquilt token", storage::Catalogue(db).HasFlight(id));
  if (!known) {
    Fail("skyquilt token",
         {ErrorCode::kNotFound,
          fmt::format("There is no flight {}. Its id stands in its address on the page.", id)});
  }
}

void Add(const TokenOptions& options) {
  const auto db = OpenCatalogue(options);
  if (!options.flight.empty()) {
    RequireFlight(*db, options.flight);
    if (options.scope != "read") {
      Refuse("skyquilt token", "A token for one flight only reads: leave --scope out.");
    }
  }
  const std::string text = options.flight.empty() ? api::NewTokenText() : api::NewShareText();
  storage::Token token;
  token.id = storage::NewId();
  token.name = options.name;
  token.hash = api::HashToken(text);
  token.scope = storage::ScopeFrom(options.scope).value_or(storage::Scope::kRead);
  token.created = storage::Now();
  token.flight_id = options.flight;
  if (options.days > 0) token.expires = token.created + std::chrono::hours(24) * options.days;
  if (!options.expires.empty()) token.expires = token.created + *ParseDuration(options.expires);
  if (options.max_gb > 0.0) token.max_bytes = static_cast<std::int64_t>(options.max_gb * 1e9);
  if (options.requests_per_minute > 0) token.requests_per_minute = options.requests_per_minute;
  OrFail("skyquilt token", storage::Tokens(*db).Add(token));
  // The token alone on the standard output, for scripts; it is never shown again.
  fmt::print("{}\n", text);
}

void List(const TokenOptions& options) {
  const auto db = OpenCatalogue(options);
  const storage::TokenSet set = OrFail("skyquilt token", storage::Tokens(*db).Read());
  if (set.tokens.empty()) fmt::print(stderr, "There are no tokens. \"skyquilt token add\" makes one.\n");
  for (const storage::Token& token : set.tokens) {
    fmt::print(
        "{:<20} {:<7} made {} {}{}{}{}\n", token.name, storage::ScopeName(token.scope),
        api::FormatTime(token.created),
        token.expires ? "ends " + api::FormatTime(*token.expires) : std::string("never ends"),
        token.max_bytes ? fmt::format(", {:g} GB", static_cast<double>(*token.max_bytes) / 1e9) : "",
        token.requests_per_minute ? fmt::format(", {} requests a minute", *token.requests_per_minute) : "",
        token.flight_id.empty() ? "" : ", only flight " + token.flight_id);
  }
}

void Revoke(const TokenOptions& options) {
  const auto db = OpenCatalogue(options);
  OrFail("skyquilt token", storage::Tokens(*db).Revoke(options.name));
}

}  // namespace

void AddTokenCommand(CLI::App& app) {
  const auto options = std::make_shared<TokenOptions>();
  CLI::App* command = app.add_subcommand("token", "Say who may use a server: add, list or revoke tokens");
  command->require_subcommand(1);
  const auto with_data = [&](CLI::App* sub) {
    sub->add_option("--data", options->data_dir, "Data folder of the server")->required();
    AddCatalogueOptions(*sub, options->catalogue);
    AddBlobAddress(*sub, options->blobs);
    return sub;
  };
  const auto with_name = [&](CLI::App* sub) {
    sub->add_option("name", options->name, "What to call the token")->required();
    return sub;
  };
  CLI::App* add = with_name(with_data(command->add_subcommand("add", "Make a token and print it, once")));
  add->add_option("--scope", options->scope, "What it may do; each includes those before")
      ->check(OneOf(std::vector<std::string>{"read", "upload", "admin"}))
      ->capture_default_str();
  add->add_option("--flight", options->flight,
                  "Id of the one flight that it opens, for reading (default: every flight)");
  add->add_option("--expires", options->expires, "How long it is good for: 12h, 30d, 8w (default: for ever)")
      ->check([](const std::string& text) {
        return ParseDuration(text) ? std::string()
                                   : "must be a number with s, m, h, d or w behind it, as 30d";
      });
  add->add_option("--days", options->days, "Days until it ends (0: never)")
      ->check(CLI::Range(0, 36500))
      ->capture_default_str()
      ->excludes("--expires");
  add->add_option("--most-gb", options->max_gb, "Gigabytes of files that its flights may hold (0: no limit)")
      ->check(CLI::Range(0.0, 1e6));
  add->add_option("--per-minute", options->requests_per_minute, "Requests a minute (0: no limit)")
      ->check(CLI::Range(0, 1'000'000));
  add->callback([options] { Add(*options); });
  with_data(command->add_subcommand("list", "List the tokens"))->callback([options] { List(*options); });
  with_name(
      with_data(command->add_subcommand("revoke", "End a token; a running server knows within a second")))
      ->callback([options] { Revoke(*options); });
}

}  // namespace skyquilt::server
