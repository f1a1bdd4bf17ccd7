#include "server/usage/storage_options.h"

#include <stdlib.h>

#include <CLI/CLI.hpp>

#include "server/terminal/fail.h"
#include "storage/blobs/s3/s3_settings.h"

namespace skyquilt::server {
namespace {

// Below this, the tiles of one map push each other out.
constexpr std::int64_t kMinCacheBytes = std::int64_t{64} << 20;
constexpr std::int64_t kMaxCacheBytes = std::int64_t{1} << 50;

}  // namespace

void AddCatalogueOptions(CLI::App& command, CatalogueOptions& options) {
  command.add_option(
      "--catalogue", options.url,
      "Where the catalogue and the queue lie: postgresql://USER@HOST/DATABASE, for several servers and workers on one "
      "catalogue (default: in the data folder)");
  command.add_option("--catalogue-password-file", options.password_file,
                     "File with the password of --catalogue (default: PGPASSWORD, PGPASSFILE or ~/.pgpass)");
}

storage::CataloguePlace PlaceOf(const char* program, const CatalogueOptions& options) {
  return OrFail(program, storage::CataloguePlaceFrom(options.url, options.password_file));
}

std::vector<std::string> WordsOfPlace(const storage::CataloguePlace& place) {
  if (!place.IsPostgres()) return {};
  if (!place.password.empty()) setenv("PGPASSWORD", place.password.c_str(), 1);
  std::string url = place.url;
  if (!place.schema.empty())
    url += (url.find('?') == std::string::npos ? "?schema=" : "&schema=") + place.schema;
  return {"--catalogue", url};
}

void AddBlobAddress(CLI::App& command, storage::BlobPlace& place) {
  command
      .add_option(
          "--blobs", place.address,
          "Where photos and maps lie, instead of the data folder: s3://bucket/prefix. Endpoint, region "
          "and keys come from AWS_... variables, a profile or the machine's role")
      ->check([](const std::string& text) {
        if (text.empty()) return std::string();
        const auto settings = storage::ReadS3Settings(text, storage::EnvironmentVariable);
        return settings ? std::string() : settings.error().message;
      });
}

void AddBlobOptions(CLI::App& command, storage::BlobPlace& place) {
  AddBlobAddress(command, place);
  command
      .add_option("--cache-bytes", place.cache_bytes,
                  "With --blobs: how much of them is kept on this machine's disk, such as 50GB")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::Range(kMinCacheBytes, kMaxCacheBytes))
      ->capture_default_str();
}

std::vector<std::string> BlobWords(const storage::BlobPlace& place) {
  if (place.address.empty()) return {};
  return {"--blobs", place.address, "--cache-bytes", std::to_string(place.cache_bytes)};
}

}  // namespace skyquilt::server
