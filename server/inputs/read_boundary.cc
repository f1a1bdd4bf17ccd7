#include "server/inputs/read_boundary.h"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include "server/terminal/fail.h"
#include "storage/exports/custom/boundary.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {

geo::Boundary ReadBoundary(const char* command, const std::filesystem::path& file) {
  std::error_code error;  // what cannot be read says so below
  if (std::filesystem::file_size(file, error) > storage::kMaxBoundaryBytes && !error) {
    Fail(command, {ErrorCode::kTooLarge,
                   fmt::format("{} has more than {} MiB; simplify the boundary.", file.string(),
                               storage::kMaxBoundaryBytes >> 20),
                   ""});
  }
  const Result<std::string> bytes = storage::ReadWholeFile(file);
  if (!bytes) Fail(command, bytes.error());
  Result<geo::Boundary> boundary = storage::ParseBoundaryFile(*bytes);
  if (!boundary) {
    Error refused = boundary.error();
    refused.message = file.string() + ": " + refused.message;
    Fail(command, refused);
  }
  return *std::move(boundary);
}

}  // namespace skyquilt::server
