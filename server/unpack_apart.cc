#include "server/unpack_apart.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "server/process_limits.h"
#include "server/spawn_self.h"
#include "storage/ids.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using storage::UnpackedFile;

// libarchive and zlib stay far below; the program itself comes on top.
constexpr std::int64_t kMemoryBytes = std::int64_t{256} << 20;
// Unpacking a photo archive takes about a second of CPU a GiB; a second a MiB is for the slowest of disks and
// machines.
constexpr std::int64_t kCpuS = 60;
// What 20 000 entries say of themselves is a few MiB.
constexpr std::size_t kMostAnswerBytes = std::size_t{64} << 20;

Json ErrorJson(const Error& error) {
  return {{"code", static_cast<int>(error.code)}, {"message", error.message}, {"detail", error.detail}};
}

Error ErrorOf(const Json& json) {
  return {static_cast<ErrorCode>(json.at("code").get<int>()), json.at("message"), json.at("detail")};
}

Error NotTaken(std::string detail) {
  return {ErrorCode::kUnprocessable,
          "The archive was not taken: unpacking it took more memory or time than the server gives for it.",
          std::move(detail)};
}

// Gone with all that is in it at the end.
class StagingFolder {
 public:
  explicit StagingFolder(fs::path path) : path_(std::move(path)) {}
  ~StagingFolder() {
    std::error_code stays;  // then the sweep of the next start removes it
    fs::remove_all(path_, stays);
  }
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// Everything that comes out of `fd`, which is closed then; nothing where it is too much.
std::optional<std::string> ReadAll(int fd) {
  std::string all;
  char block[16 * 1024];
  while (true) {
    const ssize_t got = read(fd, block, sizeof(block));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0 || all.size() > kMostAnswerBytes) break;
    all.append(block, static_cast<std::size_t>(got));
  }
  close(fd);
  if (all.size() > kMostAnswerBytes) return std::nullopt;
  return all;
}

Result<std::vector<UnpackedFile>> Parse(const std::string& answer) {
  try {
    const Json json = Json::parse(answer);
    if (json.contains("error")) return ErrorOf(json.at("error"));
    std::vector<UnpackedFile> files;
    for (const Json& entry : json.at("files")) {
      UnpackedFile file;
      file.file = {entry.at("name"), entry.at("stored_name"), entry.at("bytes")};
      if (entry.contains("error")) file.error = ErrorOf(entry.at("error"));
      if (!file.error && !storage::IsId(file.file.stored_name))
        return NotTaken("a stored name is none of ours");
      files.push_back(std::move(file));
    }
    return files;
  } catch (const Json::exception& broken) {
    return NotTaken(std::string("its answer cannot be read: ") + broken.what());
  }
}

// The files of the staging folder under names of the flight's own. All or none.
Result<std::vector<UnpackedFile>> TakeOver(const storage::PhotoStore& store, const std::string& flight_id,
                                           const storage::DataDir& staging, std::vector<UnpackedFile> files) {
  std::vector<std::string> taken;
  for (UnpackedFile& file : files) {
    if (file.error) continue;
    Result<std::string> adopted = store.Adopt(flight_id, staging.Files(flight_id) / file.file.stored_name);
    if (!adopted) {
      for (const std::string& name : taken) store.Remove(flight_id, name);
      return adopted.error();
    }
    taken.push_back(*adopted);
    file.file.stored_name = *std::move(adopted);
  }
  return files;
}

}  // namespace

Result<std::vector<UnpackedFile>> UnpackApart(const storage::PhotoStore& store, const std::string& flight_id,
                                              const fs::path& archive) {
  const StagingFolder folder(store.dir().Incoming() / ("unpack-" + storage::NewId()));
  const Result<storage::DataDir> staging = storage::DataDir::Open(folder.path());
  if (!staging) return staging.error();
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    return Error{ErrorCode::kUnavailable, "The server has no means left for this archive. Try again later.",
                 std::system_category().message(errno)};
  }
  const Result<pid_t> child = SpawnSelf({"unpack", "--staging", folder.path().string(), "--flight", flight_id,
                                         "--parent", std::to_string(getpid()), archive.string()},
                                        ends[1]);
  close(ends[1]);
  const std::optional<std::string> answer = ReadAll(ends[0]);
  if (!child) return child.error();
  int status = 0;
  while (waitpid(*child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return NotTaken("it ended " + HowItEnded(status));
  if (!answer) return NotTaken("it said too much");
  Result<std::vector<UnpackedFile>> files = Parse(*answer);
  if (!files) return files.error();
  return TakeOver(store, flight_id, *staging, *std::move(files));
}

void UnpackHere(const fs::path& staging, const std::string& flight_id, const fs::path& archive) {
  const storage::ArchiveLimits limits;
  std::error_code missing;  // then the unpacking says so
  const std::uintmax_t archive_bytes = fs::file_size(archive, missing);
  LimitThisProcess({.more_memory_bytes = kMemoryBytes,
                    .more_cpu_s = kCpuS + (missing ? 0 : static_cast<std::int64_t>(archive_bytes >> 20)),
                    .file_bytes = limits.file_bytes});
  Json answer;
  const Result<storage::DataDir> dir = storage::DataDir::Open(staging);
  const Result<std::vector<UnpackedFile>> files =
      dir ? storage::UnpackArchive(storage::PhotoStore(*dir), flight_id, archive, limits) : dir.error();
  if (files) {
    answer["files"] = Json::array();
    for (const UnpackedFile& file : *files) {
      Json entry = {
          {"name", file.file.name}, {"stored_name", file.file.stored_name}, {"bytes", file.file.bytes}};
      if (file.error) entry["error"] = ErrorJson(*file.error);
      answer["files"].push_back(std::move(entry));
    }
  } else {
    answer["error"] = ErrorJson(files.error());
  }
  const std::string text = answer.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace skyquilt::server
