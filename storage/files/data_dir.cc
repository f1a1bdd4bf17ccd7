#include "storage/files/data_dir.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/base/check.h"
#include "core/base/text/plain_text.h"
#include "storage/db/ids.h"

namespace skyquilt::storage {

namespace {

constexpr const char* kFlightsPrefix = "flights/";

}  // namespace

std::string RevisionFolderName(std::int64_t revision) { return fmt::format("r{}", revision); }

std::optional<std::int64_t> RevisionOfFolder(const std::string& name) {
  if (name.size() < 2 || name.front() != 'r') return std::nullopt;
  const auto number = ParseNumber<std::int64_t>(std::string_view(name).substr(1));
  return number && *number >= 1 && RevisionFolderName(*number) == name ? number : std::nullopt;
}

std::string FlightPrefix(const std::string& flight_id) {
  SKYQUILT_CHECK(IsId(flight_id), "an unchecked id came near a key");
  return kFlightsPrefix + flight_id + "/";
}

std::string FilesPrefix(const std::string& flight_id) { return FlightPrefix(flight_id) + "files/"; }

std::string RevisionPrefix(const std::string& flight_id, std::int64_t revision) {
  return FlightPrefix(flight_id) + RevisionFolderName(revision) + "/";
}

std::optional<FlightBlob> FlightBlobOf(std::string_view key) {
  if (!key.starts_with(kFlightsPrefix)) return std::nullopt;
  key.remove_prefix(std::string_view(kFlightsPrefix).size());
  const std::size_t id_end = key.find('/');
  if (id_end == key.npos || !IsId(key.substr(0, id_end))) return std::nullopt;
  const std::size_t folder_end = key.find('/', id_end + 1);
  if (folder_end == key.npos) return std::nullopt;
  return FlightBlob{std::string(key.substr(0, id_end)),
                    std::string(key.substr(id_end + 1, folder_end - id_end - 1)),
                    std::string(key.substr(folder_end + 1))};
}

std::string UnitsFolderName(const std::string& units_of) { return "units-" + units_of; }

bool IsUnitsFolder(const std::string& name) { return name.starts_with("units-"); }

std::string UnitsWorkName(const std::string& units_of) { return units_of + "-units"; }

bool IsUnitsWork(const std::string& name) { return name.ends_with("-units"); }

DataDir DataDir::At(const std::filesystem::path& root, const std::string& id) {
  return {std::filesystem::absolute(root).lexically_normal(), id};
}

Result<DataDir> DataDir::Open(const std::filesystem::path& root, const std::string& id) {
  std::error_code error;
  DataDir dir = At(root, id);
  const auto fail = [&](const std::filesystem::path& folder) {
    const bool is_full = error == std::errc::no_space_on_device;
    return Error{is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
                 fmt::format("The folder {} cannot be made: {}.", folder.string(), error.message()), ""};
  };
  if (!std::filesystem::exists(dir.root(), error)) {
    const std::filesystem::path named = dir.root().has_filename() ? dir.root() : dir.root().parent_path();
    std::filesystem::create_directories(named.parent_path(), error);
    if (error) return fail(named.parent_path());
    if (mkdir(named.c_str(), 0700) != 0 && errno != EEXIST) {
      error.assign(errno, std::system_category());
      return fail(named);
    }
  }
  // One level at a time: a root that goes away meanwhile is not made anew.
  for (const auto& folder : {dir.Flights(), dir.Uploads(), dir.Incoming(), dir.Work()}) {
    std::filesystem::create_directory(folder, error);
    if (error) return fail(folder);
  }
  return dir;
}

std::string DataDir::NewTemporaryName(const std::string& kind) const {
  return fmt::format("{}-{}-{}", kind, id_, NewId());
}

bool DataDir::IsTemporaryName(const std::string& kind, const std::string& name) const {
  const std::string prefix = fmt::format("{}-{}-", kind, id_);
  return !id_.empty() && name.starts_with(prefix) && IsId(std::string_view(name).substr(prefix.size()));
}

std::filesystem::path DataDir::Flight(const std::string& flight_id) const {
  SKYQUILT_CHECK(IsId(flight_id), "an unchecked id came near a path");
  return Flights() / flight_id;
}

std::filesystem::path DataDir::Files(const std::string& flight_id) const {
  return Flight(flight_id) / "files";
}

std::filesystem::path DataDir::Revision(const std::string& flight_id, std::int64_t revision) const {
  return Flight(flight_id) / RevisionFolderName(revision);
}

Result<DataDirLock> DataDirLock::Take(const DataDir& dir) {
  const std::string path = dir.root().string();
  FileDescriptor folder(open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) {
    return Error{ErrorCode::kIo,
                 fmt::format("The data folder {} cannot be opened: {}.", path, std::strerror(errno)), ""};
  }
  FileDescriptor old(open((dir.root() / "server.lock").c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  for (const int each : {folder.get(), old.get()}) {
    if (each < 0 || flock(each, LOCK_EX | LOCK_NB) == 0) continue;
    if (errno == EWOULDBLOCK) {
      return Error{ErrorCode::kConflict,
                   "Another server or \"skyquilt data\" uses " + path +
                       " already. Stop it, or use another --data folder.",
                   ""};
    }
    return Error{
        ErrorCode::kIo,
        fmt::format(
            "The data folder {} cannot be locked ({}), so that two servers could write to it at once. "
            "Use a folder on a local disk.",
            path, std::strerror(errno)),
        ""};
  }
  return DataDirLock(std::move(folder), std::move(old));
}

}  // namespace skyquilt::storage
