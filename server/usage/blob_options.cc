#include "server/usage/blob_options.h"

#include <CLI/CLI.hpp>

#include "storage/blobs/s3/s3_settings.h"

namespace skyquilt::server {
namespace {

// Below this, the tiles of one map push each other out.
constexpr std::int64_t kMinCacheBytes = std::int64_t{64} << 20;
constexpr std::int64_t kMaxCacheBytes = std::int64_t{1} << 50;

}  // namespace

BlobOptions AddBlobOptions(CLI::App& command, storage::BlobPlace& place) {
  CLI::Option* address =
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
  CLI::Option* cache_bytes =
      command
          .add_option("--cache-bytes", place.cache_bytes,
                      "With --blobs: how much of them is kept on this machine's disk, such as 50GB")
          ->transform(CLI::AsSizeValue(false))
          ->check(CLI::Range(kMinCacheBytes, kMaxCacheBytes))
          ->capture_default_str();
  return {address, cache_bytes};
}

std::vector<std::string> BlobWords(const storage::BlobPlace& place) {
  if (place.address.empty()) return {};
  return {"--blobs", place.address, "--cache-bytes", std::to_string(place.cache_bytes)};
}

}  // namespace skyquilt::server
