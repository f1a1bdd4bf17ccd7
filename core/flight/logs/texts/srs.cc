#include "core/flight/logs/texts/srs.h"

#include <fmt/format.h>
#include <proj.h>

#include <cmath>
#include <vector>

#include "core/flight/logs/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLongestSrsLine = 512;

// The words PROJ understands for a line; nothing when we do not take it.
std::optional<std::string> DefinitionOf(std::string_view line) {
  line = Trim(line);
  const std::string lower = LowerCase(line);
  if (line.empty() || line.size() > kLongestSrsLine) return std::nullopt;
  if (lower.starts_with("epsg:")) {
    const auto code = ParseInteger(line.substr(5));
    if (!code || *code < 1024 || *code > 999'999) return std::nullopt;
    return fmt::format("EPSG:{}", *code);
  }
  if (lower.starts_with("wgs84") || lower.starts_with("wgs 84")) {
    std::vector<std::string_view> words;
    const std::string_view rest = Trim(std::string_view(lower).substr(lower.find("84") + 2));
    SplitBlanks(rest, words);
    if (words.empty()) return "EPSG:4326";
    // "UTM 16N", "UTM zone 16 N", "/ UTM zone 16N"
    std::string zone;
    bool is_utm = false;
    for (const std::string_view word : words) {
      if (word == "utm")
        is_utm = true;
      else if (word != "zone" && word != "/")
        zone += word;
    }
    if (!is_utm || zone.size() < 2) return std::nullopt;
    const char half = zone.back();
    const auto number = ParseInteger(std::string_view(zone).substr(0, zone.size() - 1));
    if (!number || *number < 1 || *number > 60 || (half != 'n' && half != 's')) return std::nullopt;
    return fmt::format("EPSG:{}", (half == 'n' ? 32600 : 32700) + *number);
  }
  if (lower.starts_with("+proj=")) {
    // Files that the string could make PROJ open, and other than plain systems, are not for strangers to
    // name.
    for (const std::string_view no : {"grids", "pipeline", "+init", "+step", "/", "@", "file", "+inv"}) {
      if (lower.find(no) != std::string::npos) return std::nullopt;
    }
    return std::string(line) + " +type=crs";
  }
  return std::nullopt;
}

}  // namespace

struct ReferenceSystem::Impl {
  std::string name;
  PJ_CONTEXT* context = proj_context_create();
  PJ* transform = nullptr;
  double metres_per_unit = 1.0;

  Impl() { proj_log_level(context, PJ_LOG_NONE); }
  ~Impl() {
    proj_destroy(transform);
    proj_context_destroy(context);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void ReadUnit(const std::string& definition) {
    PJ* crs = proj_create(context, definition.c_str());
    if (crs == nullptr) return;
    if (proj_get_type(crs) == PJ_TYPE_PROJECTED_CRS) {
      PJ* axes = proj_crs_get_coordinate_system(context, crs);
      double factor = 1.0;
      if (axes != nullptr &&
          proj_cs_get_axis_info(context, axes, 0, nullptr, nullptr, nullptr, &factor, nullptr, nullptr,
                                nullptr) != 0 &&
          factor > 1e-3 && factor < 1e4) {
        metres_per_unit = factor;
      }
      proj_destroy(axes);
    }
    proj_destroy(crs);
  }
};

ReferenceSystem::ReferenceSystem(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ReferenceSystem::ReferenceSystem(ReferenceSystem&&) noexcept = default;
ReferenceSystem& ReferenceSystem::operator=(ReferenceSystem&&) noexcept = default;
ReferenceSystem::~ReferenceSystem() = default;

Result<ReferenceSystem> ReferenceSystem::Parse(std::string_view line) {
  const Error unknown{
      ErrorCode::kUnsupportedFormat,
      fmt::format("\"{}\" names no reference system; write EPSG:n, WGS84 UTM 32N or a +proj= string",
                  std::string(Trim(line).substr(0, 80))),
      ""};
  const auto definition = DefinitionOf(line);
  if (!definition) return unknown;
  auto impl = std::make_unique<Impl>();
  impl->name = Trim(line);
  PJ* raw = proj_create_crs_to_crs(impl->context, definition->c_str(), "EPSG:4326", nullptr);
  if (raw == nullptr) return unknown;
  // Always x = east or longitude first, whatever the authority's order of axes.
  impl->transform = proj_normalize_for_visualization(impl->context, raw);
  proj_destroy(raw);
  if (impl->transform == nullptr) return unknown;
  impl->ReadUnit(*definition);
  return ReferenceSystem(std::move(impl));
}

Result<geo::LatLon> ReferenceSystem::ToLatLon(double x, double y) const {
  const PJ_COORD out = proj_trans(impl_->transform, PJ_FWD, proj_coord(x, y, 0.0, HUGE_VAL));
  const bool failed = proj_errno(impl_->transform) != 0;
  proj_errno_reset(impl_->transform);
  auto position = geo::LatLon::Make(out.xy.y, out.xy.x);
  if (failed || !position) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("({}, {}) lies outside the area of {}", x, y, impl_->name), ""};
  }
  return *position;
}

double ReferenceSystem::metres_per_unit() const { return impl_->metres_per_unit; }
const std::string& ReferenceSystem::name() const { return impl_->name; }

bool LooksLikeReferenceSystem(std::string_view line) { return DefinitionOf(line).has_value(); }

std::vector<std::string_view> FirstReferencedRow(LogBytes head) {
  std::vector<std::string_view> words;
  if (!LooksLikeText(TextOf(head))) return words;
  LineReader lines(TextOf(head));
  std::string_view line;
  if (!lines.Next(line) || !LooksLikeReferenceSystem(line)) return words;
  while (lines.Next(line)) {
    SplitBlanks(line, words);
    if (!words.empty() && words[0].front() != '#') return words;
  }
  return {};
}

}  // namespace skyquilt::flight
