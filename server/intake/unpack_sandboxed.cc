#include "server/intake/unpack_sandboxed.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/scoped_folder.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "server/sandbox/run_sandboxed.h"
#include "server/sandbox/sandbox.h"
#include "server/sandbox/sandboxed_child.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using storage::UnpackedFile;

// libarchive and zlib stay far below; the program itself comes on top.
constexpr std::int64_t kMemoryBytes = std::int64_t{256} << 20;
// Unpacking a photo archive takes about a second of CPU a GiB; a second a MiB is for the slowest of disks and
// machines.
constexpr std::int64_t kUnpackCpuS = 60;
// A disk that is slow, and others that compute, are given their time.
constexpr std::int64_t kUnpackWallSecondsPerCpuSecond = 4;
// What 20 000 entries say of themselves is a few MiB.
constexpr std::size_t kMaxAnswerBytes = std::size_t{64} << 20;

constexpr const char* kUnpackRefusal =
    "The archive was not taken: unpacking it took more memory or time than the server gives for it.";

Error NotTaken(std::string detail) { return {ErrorCode::kUnprocessable, kUnpackRefusal, std::move(detail)}; }

std::int64_t CpuSecondsFor(const fs::path& archive) {
  std::error_code missing;  // then the unpacking says so
  const std::uintmax_t bytes = fs::file_size(archive, missing);
  return kUnpackCpuS + (missing ? 0 : static_cast<std::int64_t>(bytes >> 20));
}

Result<std::vector<UnpackedFile>> Parse(const std::string& answer) {
  try {
    const Json json = ParseJson(answer);
    std::vector<UnpackedFile> files;
    for (const Json& entry : json.at("files")) {
      UnpackedFile file;
      file.file = {entry.at("name"), entry.at("stored_name"), entry.at("bytes")};
      if (entry.contains("error")) {
        file.error = ErrorOfJson(entry.at("error"));
        if (!file.error) return NotTaken("an error is none");
        // A file that cannot be taken is the only kind of error that a file can have.
        file.error->code = ErrorCode::kUnprocessable;
      }
      if (!file.error && !storage::IsId(file.file.stored_name))
        return NotTaken("a stored name is none of ours");
      if (!file.error && !storage::CheckFileName(file.file.name)) return NotTaken("a name is none of a file");
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
    std::error_code missing;
    const fs::path path = staging.Files(flight_id) / file.file.stored_name;
    // A link would lead to what the unpacker itself may not read.
    const bool is_file = fs::is_regular_file(fs::symlink_status(path, missing));
    Result<std::string> adopted =
        is_file ? store.Adopt(flight_id, path) : NotTaken("what it unpacked is no file");
    if (!adopted) {
      for (const std::string& name : taken) store.Remove(flight_id, name);
      return adopted.error();
    }
    taken.push_back(*adopted);
    file.file.bytes = static_cast<std::int64_t>(fs::file_size(path, missing));
    file.file.stored_name = *std::move(adopted);
  }
  return files;
}

}  // namespace

Result<std::vector<UnpackedFile>> UnpackSandboxed(const storage::PhotoStore& store,
                                                  const std::string& flight_id, const fs::path& archive,
                                                  std::int64_t max_bytes) {
  const ScopedFolder folder(store.dir().Incoming() / store.dir().NewTemporaryName(storage::kUnpackKind));
  std::error_code unmade;
  if (!fs::create_directory(folder.path(), unmade))
    return storage::FileError("cannot make", folder.path(), unmade.value());
  SKYQUILT_TRY_ASSIGN(const storage::DataDir staging, storage::DataDir::Open(folder.path()));
  // Below `staging`, a data folder, comes what is in it.
  const Json task = {{"archive", archive.string()},
                     {"staging", folder.path().string()},
                     {"flight", flight_id},
                     {"max_bytes", max_bytes}};
  const Result<std::string> answer =
      RunSandboxed({.command = "unpack",
                    .task = JsonText(task),
                    .deadline = std::chrono::seconds(kUnpackWallSecondsPerCpuSecond * CpuSecondsFor(archive)),
                    .max_answer_bytes = kMaxAnswerBytes,
                    .refusal = kUnpackRefusal});
  if (!answer) return answer.error();
  SKYQUILT_TRY_ASSIGN(std::vector<UnpackedFile> files, Parse(*answer));
  return TakeOver(store, flight_id, staging, std::move(files));
}

int UnpackInSandbox(int parent) {
  return AnswerParent(parent, [](const std::string& text) -> Result<std::string> {
    const Json task = ParseJson(text);  // by our own server; if not, the exception ends us
    const fs::path archive = task.at("archive").get<std::string>();
    const fs::path staging = task.at("staging").get<std::string>();
    const storage::ArchiveLimits limits{.room_bytes = task.at("max_bytes")};
    SKYQUILT_TRY(EnterSandbox({.limits = {.more_memory_bytes = kMemoryBytes,
                                          .more_cpu_s = CpuSecondsFor(archive),
                                          .file_bytes = limits.file_bytes},
                               .files = {.reads = {archive}, .writes = {staging}},
                               .library = "libarchive.so"}));
    SKYQUILT_TRY_ASSIGN(const storage::DataDir dir, storage::DataDir::Open(staging));
    SKYQUILT_TRY_ASSIGN(const std::vector<UnpackedFile> files,
                        storage::UnpackArchive(storage::PhotoStore(dir), task.at("flight"), archive, limits));
    Json answer = {{"files", Json::array()}};
    for (const UnpackedFile& file : files) {
      Json entry = {
          {"name", file.file.name}, {"stored_name", file.file.stored_name}, {"bytes", file.file.bytes}};
      if (file.error) entry["error"] = ErrorJson(*file.error);
      answer["files"].push_back(std::move(entry));
    }
    return JsonText(answer);
  });
}

}  // namespace skyquilt::server
