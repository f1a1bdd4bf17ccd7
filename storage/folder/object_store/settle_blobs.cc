#include "storage/folder/object_store/settle_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/blobs/s3/s3_client.h"
#include "storage/files/publish_file.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/disk_flights.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kMarkerKey = "skyquilt-data.json";
constexpr std::int64_t kMaxOwnerBytes = 4096;

std::string MarkerOf(const std::string& catalogue_id) {
  return fmt::format(
      "{{\"format\": 1, \"id\": \"{}\", \"about\": \"Photos and maps of a Skyquilt server. Keep this file.\"}}\n",
      catalogue_id);
}

// Whose a place is, as its marker says; absent where it has none.
Result<std::optional<std::string>> OwnerOf(BlobStore& blobs) {
  const Result<std::string> text = blobs.ReadRange(kMarkerKey, 0, kMaxOwnerBytes);
  if (!text && text.error().code == ErrorCode::kNotFound) return std::optional<std::string>();
  if (!text) return text.error();
  SKYQUILT_TRY_ASSIGN(std::string id, ParseMarker(*text));
  return std::optional<std::string>(std::move(id));
}

}  // namespace

Result<std::optional<std::string>> SettledAt(const DataDir& dir) {
  std::error_code error;
  if (!std::filesystem::exists(dir.BlobsMarker(), error)) return std::optional<std::string>();
  std::optional<std::string> blobs = TextIn(ParseJsonFile(dir.BlobsMarker()), "blobs");
  if (!blobs) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("The file {} is damaged: it says where photos and maps lie. Write "
                             "{{\"blobs\": \"s3://bucket/prefix/\"}} into it.",
                             dir.BlobsMarker().string()),
                 ""};
  }
  return blobs;
}

Result<void> SettleAt(const DataDir& dir, const std::string& address) {
  if (!address.empty())
    return WriteFileAtomically(dir.BlobsMarker(), JsonText(nlohmann::json{{"blobs", address}}) + "\n");
  std::error_code error;
  std::filesystem::remove(dir.BlobsMarker(), error);
  if (error) return FileError("cannot remove", dir.BlobsMarker(), error.value());
  return SyncFolder(dir.root());
}

Error OfAnotherCatalogue(const std::string& address, const std::string& owner,
                         const std::optional<std::string>& catalogue_id) {
  return {ErrorCode::kConflict,
          catalogue_id
              ? fmt::format("{} has photos and maps of another catalogue ({} instead of {}). Give another "
                            "bucket or prefix with --blobs.",
                            address, owner, *catalogue_id)
              : fmt::format("{} has photos and maps of another catalogue ({}), and this one is new. Say "
                            "--catalogue and --data as its servers do, or give another bucket or prefix with "
                            "--blobs. Nothing was made.",
                            address, owner),
          ""};
}

Result<void> ClaimBlobs(const std::string& catalogue_id, BlobStore& blobs) {
  SKYQUILT_TRY_ASSIGN(std::optional<std::string> owner, OwnerOf(blobs));
  if (!owner) {
    const Result<void> claimed = blobs.PutIfAbsent(kMarkerKey, MarkerOf(catalogue_id));
    if (!claimed && claimed.error().code != ErrorCode::kConflict) return claimed.error();
    SKYQUILT_TRY_ASSIGN(owner, OwnerOf(blobs));
  }
  if (owner == catalogue_id) return {};
  return OfAnotherCatalogue(blobs.Address(), owner.value_or("nobody"), catalogue_id);
}

Result<CataloguePlace> WithFilesAt(CataloguePlace place, const BlobPlace& blobs) {
  if (blobs.address.empty()) return place;
  SKYQUILT_TRY_ASSIGN(S3Settings settings, ReadS3Settings(blobs.address, EnvironmentVariable));
  place.files_at = settings.Address();
  S3Client client(std::move(settings), EnvironmentVariable);
  // The list tells a store without a marker from one that is not there.
  SKYQUILT_TRY_ASSIGN(const ListedPage listed, client.List(kMarkerKey, ""));
  const auto is_marker = [](const ListedObject& object) { return object.key == kMarkerKey; };
  if (std::none_of(listed.objects.begin(), listed.objects.end(), is_marker)) return place;
  SKYQUILT_TRY_ASSIGN(const std::string text, client.Get(kMarkerKey, 0, kMaxOwnerBytes));
  SKYQUILT_TRY_ASSIGN(place.files_of, ParseMarker(text));
  return place;
}

Result<void> CheckBlobsOf(SqlConnection& db, const std::optional<std::string>& catalogue_id,
                          const std::string& address, const std::optional<std::string>& owner) {
  SKYQUILT_TRY_ASSIGN(const std::string known, CatalogueBlobs(db));
  if (known == kInDataFolder && !address.empty()) {
    return Error{ErrorCode::kConflict,
                 fmt::format("The photos and maps of this catalogue lie in the data folder of its servers, "
                             "not at {}. Leave --blobs out, and give that folder. Nothing was changed.",
                             address),
                 ""};
  }
  if (!known.empty() && known != kInDataFolder && known != address) {
    return Error{ErrorCode::kConflict,
                 fmt::format("The photos and maps of this catalogue lie at {0}, not {1}. Say --blobs {0}. "
                             "Nothing was changed.",
                             known, address.empty() ? "in a data folder" : "at " + address),
                 ""};
  }
  if (address.empty() || (owner && owner == catalogue_id)) return {};
  if (owner) return OfAnotherCatalogue(address, *owner, catalogue_id);
  SKYQUILT_TRY_ASSIGN(const bool has_files, db.Finds("SELECT 1 FROM file LIMIT 1"));
  if (known.empty() && !has_files) return {};  // its first server
  return Error{
      ErrorCode::kConflict,
      fmt::format("The photos and maps of this catalogue are not at {}: it has no {}. Check --blobs and the "
                  "address of the store (AWS_ENDPOINT_URL). If that file alone was lost, put it back: {}",
                  address, kMarkerKey, MarkerOf(catalogue_id.value_or("..."))),
      ""};
}

Result<void> SettleBlobs(const DataDir& dir, CatalogueDb& db, BlobStore& blobs) {
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> settled, SettledAt(dir));
  const std::string root = dir.root().string();
  const std::string address = blobs.IsFolder() ? "" : blobs.Address();
  if (settled && *settled != address) {
    return Error{
        ErrorCode::kConflict,
        blobs.IsFolder()
            ? fmt::format("The photos and maps of {0} lie at {1}. Say --blobs {1}, or bring them back with "
                          "\"skyquilt data move --data {0} --from {1}\".",
                          root, *settled)
            : fmt::format("The photos and maps of {} lie at {}, not at {}.", root, *settled, address),
        ""};
  }
  if (!settled && !blobs.IsFolder()) {
    const std::vector<DiskFlight> flights = FlightsOnDisk(dir.Flights());
    if (std::any_of(flights.begin(), flights.end(), HoldsAnything)) {
      return Error{
          ErrorCode::kConflict,
          fmt::format("The photos and maps of {0} lie in that folder. Move them first: \"skyquilt data "
                      "move --data {0} --to {1}\".",
                      root, address),
          ""};
    }
  }
  std::optional<std::string> owner;
  if (!blobs.IsFolder()) {
    SKYQUILT_TRY_ASSIGN(owner, OwnerOf(blobs));
  }
  Result<void> checked = CheckBlobsOf(*db.Lock(), dir.id(), address, owner);
  if (!checked && !owner && !blobs.IsFolder()) {
    // Another that began at the same moment may have claimed it since it was looked at.
    SKYQUILT_TRY_ASSIGN(owner, OwnerOf(blobs));
    checked = CheckBlobsOf(*db.Lock(), dir.id(), address, owner);
  }
  if (!checked) return checked;
  if (!blobs.IsFolder()) {
    SKYQUILT_TRY(ClaimBlobs(dir.id(), blobs));
  }
  if (db.IsShared()) {
    // Of two servers that begin at the same moment the first says it.
    const std::string here = blobs.IsFolder() ? kInDataFolder : address;
    SKYQUILT_TRY(SayCatalogueBlobs(*db.Lock(), here));
    SKYQUILT_TRY(CheckBlobsOf(*db.Lock(), dir.id(), address, dir.id()));
  }
  if (!settled && !blobs.IsFolder()) {
    SKYQUILT_TRY(SettleAt(dir, address));
  }
  return {};
}

}  // namespace skyquilt::storage
