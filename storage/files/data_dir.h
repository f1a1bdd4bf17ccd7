// DataDir: where everything of one Skyquilt installation lies on disk. Only this file knows the names:
//   skyquilt-data.json              the marker: whose folder this is (storage/folder/data_marker)
//   catalogue.db                    flights, files, revisions, jobs
//   flights/<id>/flight.jsonl       the flight's record: its facts and the user's file names
//   flights/<id>/files/<ours>       uploaded bytes, under names we made
//   flights/<id>/r<revision>/       a finished map: mosaic.mbtiles, mosaic.tif, report.json, photos.geojson
//   flights/<id>/exports/<ours>.tif exports of maps, for a day
//   uploads/                        resumable uploads that are not complete
//   incoming/                       uploads in progress
//   work/                           jobs in progress, and what is being deleted
//   watch/sent.jsonl                what was taken from watched folders (serve --watch)
//   lost/<time>/                    files that belonged to nothing, under the path they had
//   blobs.json, cache/              where photos and maps lie elsewhere (serve --blobs): where, and what of
//                                   them was fetched; flights/<id>/ has no files and no maps then
// Temporary names below incoming/ and work/ carry the folder's id: only those are removed after a crash. A
// value.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/result.h"

namespace skyquilt::storage {

class DataDir {
 public:
  // Makes the folders that are missing; the root, if it must be made, for its owner alone. `id`: the
  // folder's, from its marker; empty for a folder without one, such as that of an archive being unpacked.
  // Errors: kIo, kOutOfSpace.
  static Result<DataDir> Open(const std::filesystem::path& root, const std::string& id = "");
  // The same names, without touching the disk.
  static DataDir At(const std::filesystem::path& root, const std::string& id = "");

  const std::filesystem::path& root() const { return root_; }
  const std::string& id() const { return id_; }
  std::filesystem::path Marker() const { return root_ / "skyquilt-data.json"; }
  std::filesystem::path Catalogue() const { return root_ / "catalogue.db"; }
  std::filesystem::path Flights() const { return root_ / "flights"; }
  std::filesystem::path Flight(const std::string& flight_id) const;
  std::filesystem::path Files(const std::string& flight_id) const;
  std::filesystem::path Revision(const std::string& flight_id, std::int64_t revision) const;
  std::filesystem::path Uploads() const { return root_ / "uploads"; }
  std::filesystem::path Incoming() const { return root_ / "incoming"; }
  std::filesystem::path Work() const { return root_ / "work"; }
  std::filesystem::path Lost() const { return root_ / "lost"; }
  std::filesystem::path Cache() const { return root_ / "cache"; }
  std::filesystem::path BlobsMarker() const { return root_ / "blobs.json"; }

  // A new name for something temporary below incoming/ or work/, such as "upload-<folder's id>-<new id>".
  std::string NewTemporaryName(const std::string& kind) const;
  // True for what NewTemporaryName gave for this kind in this very folder.
  bool IsTemporaryName(const std::string& kind, const std::string& name) const;

 private:
  DataDir(std::filesystem::path root, std::string id) : root_(std::move(root)), id_(std::move(id)) {}
  std::filesystem::path root_;
  std::string id_;
};

// Kinds of temporary names.
inline constexpr const char* kUploadKind = "upload";
inline constexpr const char* kUnpackKind = "unpack";
inline constexpr const char* kExportKind = "export";
inline constexpr const char* kPackKind = "pack";
inline constexpr const char* kImportKind = "import";
inline constexpr const char* kDeletedKind = "deleted";

// Holds the data folder for one server or one repair at a time: a lock on the folder itself, since a file in
// it could be removed and made anew. Let go by the kernel when the process ends, however it ends.
class DataDirLock {
 public:
  // kConflict when another has it; kIo where the folder cannot be opened or its file system has no locks.
  static Result<DataDirLock> Take(const DataDir& dir);

 private:
  DataDirLock(FileDescriptor folder, FileDescriptor old) : folder_(std::move(folder)), old_(std::move(old)) {}
  FileDescriptor folder_;
  FileDescriptor old_;  // server.lock, which versions before the marker lock
};

// Names a revision folder, "r7".
std::string RevisionFolderName(std::int64_t revision);
// Of a folder of that name; nothing of others.
std::optional<std::int64_t> RevisionOfFolder(const std::string& name);

// The same places as keys of blobs (storage/blobs): "flights/<id>/", "flights/<id>/files/",
// "flights/<id>/r7/".
std::string FlightPrefix(const std::string& flight_id);
std::string FilesPrefix(const std::string& flight_id);
std::string RevisionPrefix(const std::string& flight_id, std::int64_t revision);
// Such a key taken apart: "flights/<id>/r7/ranges/mosaic.sums"; nothing where it is none of a flight's
// folder.
struct FlightBlob {
  std::string flight_id, folder, name;  // "<id>", "r7", "ranges/mosaic.sums"
};
std::optional<FlightBlob> FlightBlobOf(std::string_view key);
// What the units of a cut flight made, by the job that began them: "units-<job>" below the flight, where
// photos and maps lie elsewhere, or "<job>-units" in Work().
std::string UnitsFolderName(const std::string& units_of);
bool IsUnitsFolder(const std::string& name);
std::string UnitsWorkName(const std::string& units_of);
bool IsUnitsWork(const std::string& name);

}  // namespace skyquilt::storage
