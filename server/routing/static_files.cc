#include "server/routing/static_files.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "api/downloads/send_file.h"
#include "api/http/compress.h"
#include "api/http/responses.h"
#include "api/http/target.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::server {
namespace {

constexpr std::array<std::pair<std::string_view, const char*>, 14> kTypes = {{
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".geojson", "application/geo+json"},
    {".webmanifest", "application/manifest+json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".webp", "image/webp"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".txt", "text/plain; charset=utf-8"},
}};

// Scripts and styles from here alone; tiles and previews of dropped photos as blob and data; a basemap from
// where the operator or whoever looks chose. Pages of others may frame the bare map, which changes nothing,
// and nothing else.
std::string ContentSecurityPolicy(const std::string& basemap_origins, bool may_be_framed) {
  const std::string basemap = basemap_origins.empty() ? "" : " " + basemap_origins;
  return "default-src 'self'; connect-src 'self'" + basemap + "; img-src 'self' data: blob:" + basemap +
         "; worker-src 'self' blob:; style-src 'self' 'unsafe-inline'; object-src 'none'; base-uri 'none';"
         " form-action 'self'; frame-ancestors " +
         (may_be_framed ? "*" : "'none'");
}

constexpr std::array<std::pair<const char*, const char*>, 2> kCodings = {{{"br", ".br"}, {"gzip", ".gz"}}};

constexpr std::array kPageFolders = {"src", "styles", "vendor", "images", "fonts"};

const char* TypeOf(std::string_view name) {
  for (const auto& [extension, type] : kTypes) {
    if (name.ends_with(extension)) return type;
  }
  return nullptr;
}

// Files of the page lie at the top or in its own folders; what builds the page does not belong to it.
bool IsOfThePage(const std::vector<std::string>& segments) {
  for (const std::string& segment : segments) {
    if (segment.starts_with('.')) return false;
  }
  if (segments.size() > 1) {
    for (const char* folder : kPageFolders) {
      if (segments.front() == folder) return true;
    }
    return false;
  }
  const std::string_view name = segments.front();
  return !name.ends_with(".json") && !name.ends_with(".txt");
}

// "/embed/FLIGHT": one document for all flights.
bool IsBareMap(const std::vector<std::string>& segments) {
  return segments.size() == 2 && segments.front() == "embed" && storage::IsId(segments.back());
}

// Changes with the file; links are not followed.
std::optional<std::string> EtagOf(const std::filesystem::path& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return fmt::format("\"{:x}-{:x}-{:x}\"", status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_size);
}

Result<api::Response> Find(const std::filesystem::path& folder, const api::Request& request,
                           const std::string& basemap_origins) {
  const Error missing{ErrorCode::kNotFound, "There is nothing at this address."};
  SKYQUILT_TRY_ASSIGN(api::Target target, api::ParseTarget(request.path));
  std::vector<std::string> segments = std::move(target.segments);
  const bool is_bare_map = IsBareMap(segments);
  if (is_bare_map) segments = {"embed.html"};
  if (segments.empty()) segments = {"index.html"};
  const char* type = TypeOf(segments.back());
  if (type == nullptr || !IsOfThePage(segments)) return missing;
  std::filesystem::path path = folder;
  for (const std::string& segment : segments) path /= segment;
  std::optional<std::string> etag = EtagOf(path);
  if (!etag) return missing;
  std::filesystem::path chosen = path;
  const char* coding = nullptr;
  bool has_codings = false;
  // Where the build made one and the client takes it, the smallest first.
  for (const auto& [name, ending] : kCodings) {
    const std::filesystem::path packed = path.string() + ending;
    std::optional<std::string> packed_etag = EtagOf(packed);
    if (!packed_etag) continue;
    has_codings = true;
    if (coding != nullptr || !api::TakesCoding(request, name)) continue;
    coding = name;
    chosen = packed;
    etag = std::move(packed_etag);
  }
  Result<api::Response> sent = api::SendFile(request, chosen, type, *etag);
  if (!sent) return sent.error();
  if (coding != nullptr) sent->headers.Add("Content-Encoding", coding);
  if (has_codings) sent->headers.Add("Vary", "Accept-Encoding");
  sent->headers.Add("Cache-Control", "no-cache");
  sent->headers.Add("Content-Security-Policy", ContentSecurityPolicy(basemap_origins, is_bare_map));
  return sent;
}

}  // namespace

api::Response ServePage(const std::filesystem::path& folder, const api::Request& request,
                        const std::string& basemap_origins) {
  Result<api::Response> found = Find(folder, request, basemap_origins);
  return found ? *std::move(found) : api::Problem(found.error(), request);
}

std::optional<std::filesystem::path> FindPageFolder(const std::filesystem::path& given) {
  std::vector<std::filesystem::path> candidates;
  if (!given.empty()) {
    candidates.push_back(given);
  } else {
    std::error_code unknown;  // without /proc only the other candidate is tried
    const auto binary = std::filesystem::read_symlink("/proc/self/exe", unknown);
    if (!unknown) candidates.push_back(binary.parent_path() / ".." / "share" / "skyquilt" / "web");
    candidates.emplace_back(SKYQUILT_WEB_DIR);
  }
  for (const auto& folder : candidates) {
    std::error_code missing;
    if (std::filesystem::is_regular_file(folder / "index.html", missing)) return folder;
  }
  return std::nullopt;
}

}  // namespace skyquilt::server
