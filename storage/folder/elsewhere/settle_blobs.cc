#include "storage/folder/elsewhere/settle_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/try.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/disk_flights.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kMarkerKey = "skyquilt-data.json";
constexpr std::int64_t kMaxOwnerBytes = 4096;

}  // namespace

Result<std::optional<std::string>> SettledAt(const DataDir& dir) {
  std::error_code error;
  if (!std::filesystem::exists(dir.BlobsMarker(), error)) return std::optional<std::string>();
  std::ifstream file(dir.BlobsMarker(), std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("blobs") || !json["blobs"].is_string()) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("The file {} is damaged: it says where photos and maps lie. Write "
                             "{{\"blobs\": \"s3://bucket/prefix/\"}} into it.",
                             dir.BlobsMarker().string()),
                 ""};
  }
  return std::optional<std::string>(json["blobs"].get<std::string>());
}

Result<void> SettleAt(const DataDir& dir, const std::string& address) {
  if (!address.empty())
    return WriteFileAtomically(dir.BlobsMarker(), nlohmann::json{{"blobs", address}}.dump() + "\n");
  std::error_code error;
  std::filesystem::remove(dir.BlobsMarker(), error);
  if (error) return FileError("cannot remove", dir.BlobsMarker(), error.value());
  return SyncFolder(dir.root());
}

Result<void> ClaimBlobs(const std::string& catalogue_id, BlobStore& blobs) {
  const std::string text = fmt::format(
      "{{\"format\": 1, \"id\": \"{}\", \"about\": \"Photos and maps of a Skyquilt server. Keep this file.\"}}\n",
      catalogue_id);
  Result<std::string> owner = blobs.ReadRange(kMarkerKey, 0, kMaxOwnerBytes);
  if (!owner && owner.error().code == ErrorCode::kNotFound) {
    const Result<void> claimed = blobs.PutIfAbsent(kMarkerKey, text);
    if (!claimed && claimed.error().code != ErrorCode::kConflict) return claimed.error();
    owner = blobs.ReadRange(kMarkerKey, 0, kMaxOwnerBytes);
  }
  if (!owner) return owner.error();
  SKYQUILT_TRY_ASSIGN(const std::string id, ParseMarker(*owner));
  if (id == catalogue_id) return {};
  return Error{
      ErrorCode::kConflict,
      fmt::format("{} has photos and maps of another catalogue ({} instead of {}). Give another bucket "
                  "or prefix with --blobs.",
                  blobs.Address(), id, catalogue_id),
      ""};
}

Result<void> SettleBlobs(const DataDir& dir, const std::string& catalogue_id, BlobStore& blobs) {
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> settled, SettledAt(dir));
  const std::string root = dir.root().string();
  if (blobs.IsFolder()) {
    if (!settled) return {};
    return Error{
        ErrorCode::kConflict,
        fmt::format("The photos and maps of {0} lie at {1}. Say --blobs {1}, or bring them back with "
                    "\"skyquilt data move --data {0} --from {1}\".",
                    root, *settled),
        ""};
  }
  if (settled && *settled != blobs.Address()) {
    return Error{
        ErrorCode::kConflict,
        fmt::format("The photos and maps of {} lie at {}, not at {}.", root, *settled, blobs.Address()), ""};
  }
  if (!settled) {
    const std::vector<DiskFlight> flights = FlightsOnDisk(dir.Flights());
    if (std::any_of(flights.begin(), flights.end(), HoldsAnything)) {
      return Error{
          ErrorCode::kConflict,
          fmt::format("The photos and maps of {0} lie in that folder. Move them first: \"skyquilt data "
                      "move --data {0} --to {1}\".",
                      root, blobs.Address()),
          ""};
    }
  }
  SKYQUILT_TRY(ClaimBlobs(catalogue_id, blobs));
  if (!settled) {
    SKYQUILT_TRY(SettleAt(dir, blobs.Address()));
  }
  return {};
}

}  // namespace skyquilt::storage
