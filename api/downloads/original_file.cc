#include "api/downloads/original_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "api/downloads/send_file.h"
#include "api/flights/flights.h"
#include "api/http/responses.h"
#include "api/shown_map.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 6> kShown = {{
    {".jpg", "image/jpeg"},
    {".jpeg", "image/jpeg"},
    {".png", "image/png"},
    {".webp", "image/webp"},
    {".tif", "image/tiff"},
    {".tiff", "image/tiff"},
}};

const char* ImageTypeOf(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  for (const auto& [extension, type] : kShown) {
    if (name.ends_with(extension)) return type;
  }
  return nullptr;
}

// A frame of a film: a photo of the map that nobody uploaded. It lies with the map.
Result<Response> SendFrame(Service& service, const Request& request, const std::string& flight_id,
                           const std::string& name) {
  const Error unknown{ErrorCode::kNotFound, "This flight has no file of this name.", name};
  const bool is_plain = !name.starts_with('.') && name.find_first_of("/\\") == std::string::npos;
  if (!is_plain || !name.ends_with(".jpg")) return unknown;
  const Result<ShownMap> shown = FindShownMap(service, flight_id);
  if (!shown) return unknown;
  Result<Response> sent = SendBlob(request, service.store.blobs(), shown->prefix + "frames/" + name,
                                   "image/jpeg", fmt::format("\"{}-{}\"", shown->revision, name));
  if (!sent && sent.error().code == ErrorCode::kNotFound) return unknown;
  if (sent) sent->headers.Add("Cache-Control", "no-cache");
  return sent;
}

Result<Response> Send(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  const std::string& name = request.Parameter("name");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::StoredFile> file,
                      service.catalogue.FindFile(flight_id, name));
  if (!file) return SendFrame(service, request, flight_id, name);
  const char* image_type = ImageTypeOf(name);
  // Stored names are never used again: the bytes behind one never change.
  Result<Response> sent = SendBlob(
      request, service.store.blobs(), storage::FilesPrefix(flight_id) + file->stored_name,
      image_type != nullptr ? image_type : "application/octet-stream", "\"" + file->stored_name + "\"");
  if (!sent) return sent.error();
  if (image_type == nullptr) sent->headers.Add("Content-Disposition", "attachment");
  sent->headers.Add("Cache-Control", "no-cache");
  return sent;
}

}  // namespace

void AddOriginalFileRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/files/{name}", [&](const Request& request) {
    Result<Response> sent = Send(service, request);
    return sent ? *std::move(sent) : DownloadProblem(sent.error(), request);
  });
}

}  // namespace skyquilt::api
