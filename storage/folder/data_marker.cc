#include "storage/folder/data_marker.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

constexpr int kFormat = 1;
constexpr std::size_t kMaxMarkerBytes = 4096;

Result<std::string> ReadMarkerText(const DataDir& dir) {
  std::ifstream file(dir.Marker(), std::ios::binary);
  std::string text(kMaxMarkerBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad() || !file.is_open()) {
    return Error{ErrorCode::kIo,
                 "The file " + dir.Marker().string() + " cannot be read. Does it belong to another user?",
                 ""};
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

Result<std::string> ParseMarker(std::string_view text) {
  const Error damaged{ErrorCode::kCorrupt, "The marker skyquilt-data.json is damaged.", ""};
  const auto json = ParseJson(text);
  if (!json.is_object() || !json.contains("format") || !json["format"].is_number_integer()) return damaged;
  if (json["format"].get<std::int64_t>() > kFormat) {
    return Error{ErrorCode::kConflict,
                 "This data folder was written by a newer Skyquilt. Use that version, or another folder.",
                 ""};
  }
  if (!json.contains("id") || !json["id"].is_string() || !IsId(json["id"].get<std::string>())) return damaged;
  return json["id"].get<std::string>();
}

Result<std::optional<std::string>> ReadMarker(const DataDir& dir) {
  std::error_code error;
  if (!std::filesystem::exists(std::filesystem::symlink_status(dir.Marker(), error))) {
    if (error && error != std::errc::no_such_file_or_directory) {
      return Error{ErrorCode::kIo,
                   fmt::format("{} cannot be read: {}.", dir.Marker().string(), error.message()), ""};
    }
    return std::optional<std::string>();
  }
  SKYQUILT_TRY_ASSIGN(const std::string text, ReadMarkerText(dir));
  const Result<std::string> id = ParseMarker(text);
  if (!id) return Error{id.error().code, dir.root().string() + ": " + id.error().message, id.error().detail};
  return std::optional<std::string>(*id);
}

Result<void> WriteMarker(const DataDir& dir, const std::string& id, bool is_shared) {
  return WriteFileAtomically(
      dir.Marker(),
      fmt::format(
          "{{\"format\": {}, \"id\": \"{}\", {}\"about\": \"Data folder of a Skyquilt server. Keep this file.\"}}\n",
          kFormat, id, is_shared ? "\"catalogue\": \"postgresql\", " : ""));
}

bool HasSharedCatalogue(const DataDir& dir) {
  const Result<std::string> text = ReadMarkerText(dir);
  const auto json = text ? ParseJson(*text) : nlohmann::json();
  return json.is_object() && json.value("catalogue", nlohmann::json()) == "postgresql";
}

Result<std::optional<std::string>> CatalogueId(SqlConnection& db) {
  return db.First(FirstColumn<std::string>, "SELECT id FROM data_dir");
}

Result<void> SetCatalogueId(SqlConnection& db, const std::string& id) {
  return db.Change("INSERT INTO data_dir(one, id) VALUES(1, ?) ON CONFLICT(one) DO UPDATE SET id=excluded.id",
                   id);
}

Result<std::string> CatalogueBlobs(SqlConnection& db) { return db.Text("SELECT blobs FROM data_dir"); }

Result<std::string> SayCatalogueBlobs(SqlConnection& db, const std::string& where) {
  SKYQUILT_TRY(db.Change("UPDATE data_dir SET blobs=? WHERE blobs=''", where));
  return CatalogueBlobs(db);
}

Result<void> ChangeCatalogueBlobs(SqlConnection& db, const std::string& where) {
  return db.Change("UPDATE data_dir SET blobs=?", where);
}

}  // namespace skyquilt::storage
