#include "api/http/compress.h"

#include <algorithm>
#include <array>
#include <string>

#include "api/http/accept.h"
#include "core/base/try.h"
#include "storage/pmtiles/pmtiles_archive.h"

namespace skyquilt::api {
namespace {

constexpr std::uint64_t kMinBytes = 1024;
constexpr std::uint64_t kMaxBytes = std::uint64_t{8} << 20;
constexpr int kLevel = 4;
constexpr std::array<std::string_view, 9> kTypes = {
    "application/json",    "application/geo+json", "application/problem+json", "application/xml", "text/",
    "application/vnd.ogc", "application/x-qgis",   "application/schema+json",  "image/svg+xml"};

bool IsText(std::string_view type) {
  return type.find("+json") != std::string_view::npos || type.find("+xml") != std::string_view::npos ||
         std::any_of(kTypes.begin(), kTypes.end(),
                     [&](std::string_view known) { return type.starts_with(known); });
}

Result<std::string> Whole(BodySource& source) {
  std::string text(source.length(), '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    SKYQUILT_TRY_ASSIGN(
        const std::size_t read,
        source.Read({reinterpret_cast<std::uint8_t*>(text.data()) + filled, text.size() - filled}));
    if (read == 0) break;
    filled += read;
  }
  text.resize(filled);
  return text;
}

}  // namespace

bool TakesCoding(const Request& request, std::string_view coding) {
  return NamesType(request.headers.Find("Accept-Encoding"), coding);
}

Result<void> CompressAnswer(const Request& request, Response& response) {
  if (response.wants || response.live != nullptr || response.status != 200 ||
      response.headers.Has("Content-Encoding") || !IsText(response.headers.Find("Content-Type"))) {
    return {};
  }
  const std::uint64_t size = response.source != nullptr ? response.source->length() : response.body.size();
  if (size < kMinBytes || size > kMaxBytes) return {};
  response.headers.AddVary("Accept-Encoding");
  if (!TakesCoding(request, "gzip") || request.headers.Has("Range")) return {};
  if (response.source != nullptr) {
    SKYQUILT_TRY_ASSIGN(response.body, Whole(*response.source));
    response.source.reset();
  }
  response.body = storage::Gzip(response.body, kLevel);
  response.headers.Add("Content-Encoding", "gzip");
  if (const std::string_view etag = response.headers.Find("ETag"); etag.starts_with('"'))
    response.headers.Set("ETag", "W/" + std::string(etag));
  return {};
}

}  // namespace skyquilt::api
