#include "api/http/compress.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

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
  std::string_view rest = request.headers.Find("Accept-Encoding");
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    std::string_view entry = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    entry.remove_prefix(std::min(entry.find_first_not_of(" \t"), entry.size()));
    const std::string_view name = entry.substr(0, entry.find_first_of("; \t"));
    if (!EqualsIgnoringCase(name, coding)) continue;
    return entry.find("q=0") == std::string_view::npos || entry.find("q=0.") != std::string_view::npos;
  }
  return false;
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
