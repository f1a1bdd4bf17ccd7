#include "server/commands/arguments.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "api/json/json_codec.h"
#include "core/base/text/plain_text.h"
#include "server/terminal/fail.h"
#include "server/terminal/terminal_progress.h"
#include "storage/exports/custom/boundary.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace fs = std::filesystem;

geo::LatLon ParseLatLon(const char* command, const char* option, const std::string& text) {
  geo::LatLon place;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &place.lat_deg, &place.lon_deg, &rest) == 2) return place;
  Refuse(command, fmt::format("{} is '{}'; write it as LAT,LON in degrees, like 46.80,7.10.", option, text));
}

geo::Boundary ReadBoundary(const char* command, const fs::path& file) {
  std::error_code error;  // what cannot be read says so below
  if (fs::file_size(file, error) > storage::kMaxBoundaryBytes && !error) {
    Fail(command, {ErrorCode::kTooLarge, fmt::format("{} has more than {} MiB; simplify the boundary.",
                                                     file.string(), storage::kMaxBoundaryBytes >> 20)});
  }
  const std::string bytes = OrFail(command, storage::ReadWholeFile(file));
  Result<geo::Boundary> boundary = storage::ParseBoundaryFile(bytes);
  if (!boundary) {
    Error refused = boundary.error();
    refused.message = file.string() + ": " + refused.message;
    Fail(command, refused);
  }
  return *std::move(boundary);
}

void CheckServerAddress(const char* command, std::string& url) {
  while (url.ends_with('/')) url.pop_back();
  if (url.starts_with("http://") || url.starts_with("https://")) return;
  Refuse(command, url + " is no address of a server; one looks like http://127.0.0.1:8080.");
}

std::string NameOfInput(const fs::path& input) {
  fs::path path = fs::absolute(input).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  const fs::path name = fs::is_directory(path) ? path.filename() : path.stem();
  return CutToBytes(name.string(), api::kMaxFlightNameBytes);
}

UploadedFlight UploadAtTerminal(const char* command, const std::vector<flight::InputFile>& files,
                                const UploadOptions& options) {
  std::string flight_id;
  Result<UploadedFlight> uploaded = [&] {
    TerminalProgress progress;
    return UploadFlight(
        files, options, [&](const std::string& id) { flight_id = id; }, progress);
  }();
  if (uploaded) return *std::move(uploaded);
  if (!flight_id.empty())
    fmt::print(stderr, "To go on where this ended: the same command with --flight {}\n", flight_id);
  Fail(command, uploaded.error());
}

void CheckOutFile(const char* command, const fs::path& out, bool may_replace) {
  std::error_code error;
  if (fs::is_directory(out, error)) Refuse(command, out.string() + " is a folder; name a file in it.");
  if (fs::exists(out, error) && !may_replace)
    Refuse(command, out.string() + " is there already. Choose another name, or say --overwrite.");
  if (!fs::is_directory(out.parent_path(), error))
    Refuse(command, "The folder " + out.parent_path().string() + " is not there. Make it first.");
}

fs::path HiddenBeside(const fs::path& out) {
  return out.parent_path() / ("." + out.filename().string() + "-" + std::to_string(getpid()));
}

WorkFolder::WorkFolder(const char* command, const fs::path& path) : folder_(path) {
  std::error_code error;
  if (!fs::create_directory(path, error))
    Fail(command, storage::FileError("cannot make", path, error ? error.value() : EEXIST));
}

}  // namespace skyquilt::server
