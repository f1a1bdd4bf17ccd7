#include "server/intake/archive_unpacker.h"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <utility>

#include "core/base/text/printable.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {

ArchiveUnpacker::ArchiveUnpacker(api::Service& service, std::vector<api::CutOffArchive> archives)
    : service_(service), archives_(std::move(archives)), thread_([this] { Run(); }) {}

void ArchiveUnpacker::Run() {
  constexpr std::chrono::milliseconds kRemovalPause{500};
  std::vector<api::CutOffArchive> unsettled;
  for (const api::CutOffArchive& archive : archives_) {
    if (thread_.IsEnded()) return;
    if (IsUnpacked(archive) && !IsSettled(archive)) unsettled.push_back(archive);
  }
  while (!unsettled.empty() && thread_.Rest(kRemovalPause))
    std::erase_if(unsettled, [this](const api::CutOffArchive& archive) { return IsSettled(archive); });
}

bool ArchiveUnpacker::IsUnpacked(const api::CutOffArchive& archive) {
  const Result<std::size_t> came = UnpackWhateverHappens(archive);
  const std::string name =
      fmt::format("the archive {} of flight {}", Printable(archive.file.name), archive.flight_id);
  LogEvent(came ? fmt::format("{}, which a stop cut off, is unpacked: {} more came in", name,
                              Counted(*came, "file"))
                : fmt::format("{} is not unpacked and stays: {} {}", name, came.error().message,
                              came.error().detail));
  return came.ok();
}

// False: a job reads the flight's files now.
bool ArchiveUnpacker::IsSettled(const api::CutOffArchive& archive) {
  const Result<void> removed = api::RemoveCutOff(service_, archive);
  if (!removed && removed.error().code == ErrorCode::kConflict) return false;
  if (!removed) LogFailure(archive.flight_id, "unpack", removed.error());
  return true;
}

// What this process is out of ends one archive, not the server.
Result<std::size_t> ArchiveUnpacker::UnpackWhateverHappens(const api::CutOffArchive& archive) {
  try {
    return api::UnpackCutOff(service_, archive);
  } catch (const std::exception& thrown) {
    return Error{ErrorCode::kOutOfSpace, "The server ran out of memory for it.", thrown.what()};
  }
}

}  // namespace skyquilt::server
