#include "core/geo/crs/reference_system.h"

#include <proj.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <list>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/text/plain_text.h"
#include "core/geo/geodesic.h"

namespace skyquilt::geo {
namespace {

constexpr std::size_t kLongestLine = 512;
constexpr std::size_t kLongestWkt = 16'384;
constexpr std::size_t kShortestName = 5;
constexpr double kExactM = 1.0;      // operations that are no better than this err by what a map shows
constexpr double kSameFrameM = 3.0;  // degrees of an older datum lie tens to hundreds of metres from WGS84's
constexpr double kUnknownShiftM = 300.0;  // as far as those

bool IsSmallLetter(char c) { return c >= 'a' && c <= 'z'; }

// Letters and digits alone: how names are compared.
std::string LettersOf(std::string_view text) {
  std::string letters = LowerCase(text);
  std::erase_if(letters, [](char c) { return !IsDigit(c) && !IsSmallLetter(c); });
  return letters;
}

std::string_view TrimmedLine(std::string_view line) {
  constexpr std::string_view kAround = " \t\r\n\"'#;,";
  if (line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
  const std::size_t begin = line.find_first_not_of(kAround);
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of(kAround) - begin + 1);
}

// The digits at `at`, or nothing.
std::string_view DigitsAt(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && IsDigit(text[end])) ++end;
  return text.substr(std::min(at, text.size()), end - std::min(at, end));
}

// Past what joins the code of heights to that before `at`: "+5773", ",crs:epsg::5773" of a URN, "&2=.../5773"
// of a URL; `at` where nothing does.
std::size_t PastJoin(const std::string& lower, std::size_t at) {
  const auto past_blanks = [&](std::size_t from) {
    return std::min(lower.find_first_not_of(' ', from), lower.size());
  };
  const std::size_t joined = past_blanks(at);
  if (joined < lower.size() && lower[joined] == '+') return past_blanks(joined + 1);
  for (const std::string_view join : {",crs:", "&2="}) {
    if (lower.compare(joined, join.size(), join) == 0)
      return std::min(lower.find("epsg", joined), lower.size());
  }
  return at;
}

constexpr std::size_t kMinDigits = 4, kMaxDigits = 6;  // of a code

// Past "epsg" at `at`, what joins it to a code and the version of the register: "epsg-code: ", "epsg.io/",
// "epsg/0/", "epsg:9.8.5:".
std::size_t PastAuthority(const std::string& lower, std::size_t at) {
  constexpr std::string_view kBetween = " :=-_/.";
  const auto past = [&](std::string_view letters, std::size_t from) {
    return std::min(lower.find_first_not_of(letters, from), lower.size());
  };
  if (lower.compare(at, 4, "epsg") == 0) at += 4;
  at = past(kBetween, at);
  for (const std::string_view word : {"code", "io"}) {
    if (lower.compare(at, word.size(), word) == 0) at = past(kBetween, at + word.size());
  }
  const std::size_t end = past("0123456789.", at);
  const bool is_version = DigitsAt(lower, at).size() < kMinDigits && end < lower.size() &&
                          (lower[end] == ':' || lower[end] == '/');
  return is_version ? past(kBetween, end) : at;
}

}  // namespace

std::optional<EpsgCode> FindEpsgCode(const std::string& lower) {
  const std::size_t begin = lower.find("epsg");
  if (begin == std::string::npos) return std::nullopt;
  const std::string_view code = DigitsAt(lower, PastAuthority(lower, begin));
  if (code.size() < kMinDigits) return std::nullopt;
  const auto end_of = [&](std::string_view digits) {
    return static_cast<std::size_t>(digits.data() - lower.data()) + digits.size();
  };
  std::string definition = "EPSG:" + std::string(code);
  bool may_be_known = code.size() <= kMaxDigits;
  std::size_t end = end_of(code);
  if (const std::size_t joined = PastJoin(lower, end); joined != end) {
    const std::string_view vertical = DigitsAt(lower, PastAuthority(lower, joined));
    const bool is_code = vertical.size() >= kMinDigits;
    definition += "+" + std::string(vertical);
    may_be_known = may_be_known && is_code && vertical.size() <= kMaxDigits;
    end = is_code ? end_of(vertical) : lower.size();
  }
  return EpsgCode{begin, end - begin, may_be_known ? definition : std::string()};
}

namespace {

// Words of letters and of digits: "utm zone16n" as utm, zone, 16, n.
std::vector<std::string> WordsIn(const std::string& lower) {
  std::vector<std::string> words;
  char before = ' ';
  for (const char c : lower) {
    const bool is_digit = IsDigit(c), is_letter = IsSmallLetter(c);
    if (is_digit || is_letter) {
      const bool goes_on = is_digit ? IsDigit(before) : IsSmallLetter(before);
      if (!goes_on) words.emplace_back();
      words.back() += c;
    }
    before = c;
  }
  return words;
}

// Which half of the Earth a word behind the zone of UTM says. N and S are halves, as most lists mean them;
// the other letters are bands of MGRS, but E, which is an axis, and M and W apart from the zone: metres, the
// west.
std::optional<bool> IsNorthernHalf(std::string_view word, bool is_apart) {
  if (word == "north" || word == "northern") return true;
  if (word == "south" || word == "southern" || word == "s") return false;
  const bool is_band = word.size() == 1 && word >= "c" && word <= "x" && word != "e" && word != "i" &&
                       word != "o" && !(is_apart && (word == "m" || word == "w"));
  return is_band ? std::optional(word >= "n") : std::nullopt;
}

// "33U", and no more. "33S" may be the southern half, or the band that holds Spain and California.
bool IsZoneAlone(std::string_view line) {
  const std::size_t digits = DigitsAt(line, 0).size();
  return (digits == 1 || digits == 2) && line.size() == digits + 1 && line.back() >= 'A' &&
         line.back() <= 'Z' && line.back() != 'S';
}

// "wgs84 utm 15n", "etrs89 / utm zone 32 north", "utm 33u": the name that PROJ has for it, or WGS84's code.
std::optional<std::string> UtmIn(const std::string& lower) {
  const std::vector<std::string> words = WordsIn(lower);
  const auto utm = std::find(words.begin(), words.end(), "utm");
  if (utm == words.end()) return std::nullopt;
  auto next = utm + 1;
  if (next != words.end() && *next == "zone") ++next;
  if (next == words.end() || next->size() > 2 || !IsDigit(next->front())) return std::nullopt;
  int zone = 0;
  std::from_chars(next->data(), next->data() + next->size(), zone);
  if (zone < 1 || zone > 60) return std::nullopt;
  const std::string& digits = *next++;
  if (next == words.end()) return std::nullopt;  // which half of the Earth must be said
  const bool is_apart = lower.find(digits + *next) == std::string::npos;
  const std::optional<bool> is_north = IsNorthernHalf(*next, is_apart);
  if (!is_north) return std::nullopt;
  std::string behind;  // a datum here is one that PROJ must know
  for (++next; next != words.end(); ++next) behind += *next;
  if (!behind.empty() && behind != "wgs84" && behind != "wgs1984") return std::nullopt;
  constexpr std::string_view kBetween = " /_-:,";
  std::string datum = lower.substr(0, lower.find("utm"));
  const std::size_t last = datum.find_last_not_of(kBetween);
  datum.resize(last == std::string::npos ? 0 : last + 1);
  const std::string letters = LettersOf(datum);
  if (letters.empty() || letters == "wgs84" || letters == "wgs1984") {
    return "EPSG:" + std::to_string((*is_north ? 32600 : 32700) + zone);
  }
  return datum + " / UTM zone " + std::to_string(zone) + (*is_north ? "N" : "S");
}

bool IsWkt(const std::string& lower) {
  constexpr std::array<std::string_view, 10> kBegin = {
      "projcs[",   "projcrs[",     "geogcs[",   "geogcrs[",       "geodcrs[",
      "compd_cs[", "compoundcrs[", "boundcrs[", "geographiccrs[", "projectedcrs["};
  return std::any_of(kBegin.begin(), kBegin.end(),
                     [&](std::string_view begin) { return lower.starts_with(begin); });
}

// Files that the string could make PROJ open, and other than plain systems, are not for strangers to name.
bool IsForbidden(const std::string& lower, bool is_proj_string) {
  constexpr std::array<std::string_view, 7> kNowhere = {
      "grids", "pipeline", "+init", "parameterfile", "abridgedtransformation", "coordinateoperation",
      "+step"};
  constexpr std::array<std::string_view, 4> kNotInStrings = {"/", "@", "file", "+inv"};
  const auto is_in = [&](std::string_view word) { return lower.find(word) != std::string::npos; };
  return std::any_of(kNowhere.begin(), kNowhere.end(), is_in) ||
         (is_proj_string && std::any_of(kNotInStrings.begin(), kNotInStrings.end(), is_in));
}

// Objects of one context are for one thread at a time: what is made, used or destroyed holds the mutex.
struct Proj {
  std::mutex mutex;
  PJ_CONTEXT* context = proj_context_create();

  Proj() {
    proj_log_level(context, PJ_LOG_NONE);
    proj_context_set_enable_network(context, 0);
  }
};

Proj& TheProj() {
  static auto& proj = *new Proj;  // stays for what is destroyed when the program ends
  return proj;
}

using PjPtr = std::unique_ptr<PJ, decltype(&proj_destroy)>;
PjPtr Owned(PJ* object) { return {object, proj_destroy}; }

// The one horizontal system whose name is written so, also without the datum in front of it.
PjPtr FindByName(PJ_CONTEXT* context, const std::string& name) {
  const std::string letters = LettersOf(name);
  constexpr std::array kTypes = {PJ_TYPE_PROJECTED_CRS, PJ_TYPE_GEOGRAPHIC_2D_CRS};
  constexpr std::size_t kMaxFound = 16;
  const std::unique_ptr<PJ_OBJ_LIST, decltype(&proj_list_destroy)> found(
      proj_create_from_name(context, nullptr, name.c_str(), kTypes.data(), kTypes.size(), 1, kMaxFound,
                            nullptr),
      proj_list_destroy);
  PjPtr ending = Owned(nullptr);
  int endings = 0;
  for (int k = 0; found && k < proj_list_get_count(found.get()); ++k) {
    PjPtr one = Owned(proj_list_get(context, found.get(), k));
    if (!one || proj_is_deprecated(one.get()) != 0 || proj_get_name(one.get()) == nullptr) continue;
    const std::string own = LettersOf(proj_get_name(one.get()));
    if (own == letters) return one;
    if (letters.size() < 2 * kShortestName || !own.ends_with(letters)) continue;
    ++endings;
    ending = std::move(one);
  }
  return endings == 1 ? std::move(ending) : Owned(nullptr);
}

PjPtr CreateSystem(PJ_CONTEXT* context, std::string_view line) {
  line = TrimmedLine(line);
  if (line.empty() || line.size() > kLongestWkt) return Owned(nullptr);
  const std::string lower = LowerCase(line);
  const auto create = [&](const std::string& definition) {
    return Owned(proj_create(context, definition.c_str()));
  };
  if (IsWkt(lower)) {
    return IsForbidden(lower, false) ? Owned(nullptr) : create(std::string(line));
  }
  if (line.size() > kLongestLine) return Owned(nullptr);
  if (lower.starts_with("+proj=")) {
    return IsForbidden(lower, true) ? Owned(nullptr) : create(std::string(line) + " +type=crs");
  }
  if (const auto code = FindEpsgCode(lower); code && !code->definition.empty())
    return create(code->definition);
  const bool is_bare_code = DigitsAt(line, 0).size() == line.size() && line.size() >= 4 && line.size() <= 6;
  if (is_bare_code) return create("EPSG:" + std::string(line));
  const std::string letters = LettersOf(line);
  if (letters == "wgs84" || letters.ends_with("crs84")) return create("EPSG:4326");
  if (const auto utm = UtmIn(IsZoneAlone(line) ? "utm " + lower : lower)) {
    return utm->starts_with("EPSG:") ? create(*utm) : FindByName(context, *utm);
  }
  if (const std::size_t colon = lower.find(':'); colon != std::string::npos) {  // another authority's code
    const bool is_code =
        colon >= 3 &&
        std::all_of(lower.begin(), lower.begin() + static_cast<std::ptrdiff_t>(colon), IsSmallLetter) &&
        colon + 1 < lower.size() && DigitsAt(lower, colon + 1).size() == lower.size() - colon - 1;
    return is_code && lower.compare(0, 4, "epsg") != 0 ? create(std::string(line)) : Owned(nullptr);
  }
  // Names are looked up among thousands: only what may be one.
  const bool is_name = letters.size() >= kShortestName && lower.find("utm") == std::string::npos &&
                       lower.find_first_of("={[\"\\") == std::string::npos &&
                       std::any_of(letters.begin(), letters.end(), IsSmallLetter);
  return is_name ? FindByName(context, std::string(line)) : Owned(nullptr);
}

bool IsHorizontal(PJ_TYPE type) {
  return type == PJ_TYPE_PROJECTED_CRS || type == PJ_TYPE_GEOGRAPHIC_2D_CRS ||
         type == PJ_TYPE_GEOGRAPHIC_3D_CRS;
}

// Of the axis; 1 where it has none that makes sense.
double UnitOfAxis(PJ_CONTEXT* context, const PJ* system, int axis) {
  const PjPtr axes = Owned(proj_crs_get_coordinate_system(context, system));
  double factor = 1.0;
  const bool is_known = axes && proj_cs_get_axis_info(context, axes.get(), axis, nullptr, nullptr, nullptr,
                                                      &factor, nullptr, nullptr, nullptr) != 0;
  return is_known && factor > 1e-3 && factor < 1e4 ? factor : 1.0;
}

}  // namespace

bool AreaOfUse::Contains(const LatLon& place, double margin_deg) const {
  if (place.lat_deg < south_deg - margin_deg || place.lat_deg > north_deg + margin_deg) return false;
  const double middle_deg = 0.5 * (west_deg + east_deg);
  return std::abs(std::remainder(place.lon_deg - middle_deg, 360.0)) <=
         0.5 * (east_deg - west_deg) + margin_deg;
}

struct ReferenceSystem::Impl {
  std::string name;
  std::string definition;
  PJ_CONTEXT* context = TheProj().context;
  PJ* transform = nullptr;
  PJ* to_own_degrees = nullptr;  // of the system's own datum; null: it has none that is known
  PJ* horizontal_system = nullptr;
  bool is_geographic = false, has_older_ellipsoid = false;
  double metres_per_height_unit = 1.0;
  bool heights_are_above_sea = false;
  AreaOfUse area;

  Impl() = default;
  ~Impl() {
    const std::lock_guard lock(TheProj().mutex);
    proj_destroy(transform);
    proj_destroy(to_own_degrees);
    proj_destroy(horizontal_system);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // False where `system` is none that places.
  bool Take(const PJ* system) {
    PjPtr horizontal = Owned(nullptr), vertical = Owned(nullptr);
    if (proj_get_type(system) == PJ_TYPE_COMPOUND_CRS) {
      horizontal = Owned(proj_crs_get_sub_crs(context, system, 0));
      vertical = Owned(proj_crs_get_sub_crs(context, system, 1));
      if (!horizontal) return false;
      system = horizontal.get();
    }
    PjPtr unbound = Owned(nullptr);
    const PJ* plain = system;
    if (proj_get_type(plain) == PJ_TYPE_BOUND_CRS) {
      unbound = Owned(proj_get_source_crs(context, plain));
      plain = unbound.get();
    }
    if (plain == nullptr || !IsHorizontal(proj_get_type(plain))) return false;
    is_geographic = proj_get_type(plain) != PJ_TYPE_PROJECTED_CRS;
    if (vertical) {
      metres_per_height_unit = UnitOfAxis(context, vertical.get(), 0);
      heights_are_above_sea = true;
    } else if (!is_geographic) {
      metres_per_height_unit = UnitOfAxis(context, plain, 0);
    }
    constexpr double kPresentSemiMajorM = 6'378'137.0, kSameEllipsoidM = 10.0;
    double semi_major_m = kPresentSemiMajorM;
    if (const PjPtr ellipsoid = Owned(proj_get_ellipsoid(context, plain)))
      proj_ellipsoid_get_parameters(context, ellipsoid.get(), &semi_major_m, nullptr, nullptr, nullptr);
    has_older_ellipsoid = std::abs(semi_major_m - kPresentSemiMajorM) > kSameEllipsoidM;
    AreaOfUse used;
    if (proj_get_area_of_use(context, plain, &used.west_deg, &used.south_deg, &used.east_deg, &used.north_deg,
                             nullptr) != 0 &&
        used.west_deg >= -360.0 && used.south_deg >= -90.0 && used.north_deg <= 90.0) {
      if (used.east_deg < used.west_deg) used.east_deg += 360.0;
      area = used;
    }
    const PjPtr wgs84 = Owned(proj_create(context, "EPSG:4326"));
    const PjPtr raw = Owned(
        wgs84 ? proj_create_crs_to_crs_from_pj(context, system, wgs84.get(), nullptr, nullptr) : nullptr);
    // Always x = east or longitude first, whatever the authority's order of axes.
    if (raw) transform = proj_normalize_for_visualization(context, raw.get());
    horizontal_system = proj_clone(context, system);
    const PjPtr geodetic = Owned(proj_crs_get_geodetic_crs(context, plain));
    const PjPtr own =
        Owned(geodetic ? proj_create_crs_to_crs_from_pj(context, plain, geodetic.get(), nullptr, nullptr)
                       : nullptr);
    if (own) to_own_degrees = proj_normalize_for_visualization(context, own.get());
    return transform != nullptr;
  }

  // Nothing where it fails. An error is the context's, and stays from whatever failed before. Under the lock.
  static std::optional<PJ_COORD> Brought(PJ* by, PJ_DIRECTION direction, double x, double y) {
    proj_errno_reset(by);
    const PJ_COORD out = proj_trans(by, direction, proj_coord(x, y, 0.0, HUGE_VAL));
    return proj_errno(by) == 0 ? std::optional(out) : std::nullopt;
  }

  // Nothing where there is no such place. Under the lock.
  static std::optional<LatLon> Place(PJ* by, double x, double y) {
    const std::optional<PJ_COORD> out = Brought(by, PJ_FWD, x, y);
    if (!out) return std::nullopt;
    const auto position = LatLon::Make(out->xy.y, out->xy.x);
    return position ? std::optional(*position) : std::nullopt;
  }

  // Of the operation that is used there, where it is of an older datum and no better than a metre, or PROJ
  // takes its degrees for WGS84's as it knows no better. Under the lock.
  std::optional<double> InexactShiftM(double x, double y) const {
    if (to_own_degrees == nullptr) return std::nullopt;
    const auto own = Place(to_own_degrees, x, y), there = Place(transform, x, y);
    if (!own || !there) return std::nullopt;
    const PjPtr used = Owned(proj_trans_get_last_used_operation(transform));
    if (used && has_older_ellipsoid && proj_coordoperation_has_ballpark_transformation(context, used.get()))
      return kUnknownShiftM;
    if (MetresApart(*own, *there) < kSameFrameM) return std::nullopt;
    const double error_m = used ? proj_coordoperation_get_accuracy(context, used.get()) : -1.0;
    return error_m > kExactM ? std::optional(error_m) : std::nullopt;
  }

  // Does the best operation at `at`, of those that PROJ knows, need a grid that is not installed? Under the
  // lock.
  bool LacksGridAt(const LatLon& at) const {
    constexpr double kAroundDeg = 0.01;
    const PjPtr wgs84 = Owned(proj_create(context, "EPSG:4326"));
    const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, decltype(&proj_operation_factory_context_destroy)>
        asked(proj_create_operation_factory_context(context, nullptr),
              proj_operation_factory_context_destroy);
    if (!wgs84 || !asked || horizontal_system == nullptr) return false;
    proj_operation_factory_context_set_area_of_interest(context, asked.get(), at.lon_deg - kAroundDeg,
                                                        at.lat_deg - kAroundDeg, at.lon_deg + kAroundDeg,
                                                        at.lat_deg + kAroundDeg);
    proj_operation_factory_context_set_spatial_criterion(context, asked.get(),
                                                         PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
    proj_operation_factory_context_set_grid_availability_use(context, asked.get(),
                                                             PROJ_GRID_AVAILABILITY_IGNORED);
    const std::unique_ptr<PJ_OBJ_LIST, decltype(&proj_list_destroy)> found(
        proj_create_operations(context, horizontal_system, wgs84.get(), asked.get()), proj_list_destroy);
    if (!found || proj_list_get_count(found.get()) == 0) return false;
    const PjPtr best = Owned(proj_list_get(context, found.get(), 0));
    return best && proj_coordoperation_is_instantiable(context, best.get()) == 0;
  }

  // Nothing where `line` names no system.
  static std::shared_ptr<const Impl> Make(const std::string& line) {
    const auto impl = std::make_shared<Impl>();
    const std::lock_guard lock(TheProj().mutex);
    const PjPtr system = CreateSystem(impl->context, line);
    if (!system || !impl->Take(system.get())) return nullptr;
    impl->name = impl->definition = line;
    const char* authority = proj_get_id_auth_name(system.get(), 0);
    const char* code = proj_get_id_code(system.get(), 0);
    if (authority != nullptr && code != nullptr && std::string_view(authority) == "EPSG")
      impl->definition = std::string(authority) + ":" + code;
    return impl;
  }
};

ReferenceSystem::ReferenceSystem(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

Result<ReferenceSystem> ReferenceSystem::Parse(std::string_view line) {
  constexpr std::size_t kLinesKept = 16;
  static std::mutex mutex;
  static auto& kept = *new std::list<std::pair<std::string, std::shared_ptr<const Impl>>>;  // latest first
  const std::string text(TrimmedLine(line).substr(0, kLongestWkt + 1));
  const std::lock_guard lock(mutex);
  const auto found =
      std::find_if(kept.begin(), kept.end(), [&](const auto& parsed) { return parsed.first == text; });
  if (found != kept.end()) {
    kept.splice(kept.begin(), kept, found);
  } else {
    kept.emplace_front(text, Impl::Make(text));
    if (kept.size() > kLinesKept) kept.pop_back();
  }
  if (kept.front().second) return ReferenceSystem(kept.front().second);
  return Error{
      ErrorCode::kUnsupportedFormat,
      "\"" + text.substr(0, 80) +
          "\" names no reference system that is known; write its EPSG code (EPSG:32615), a name such as "
          "WGS84 UTM 15N, a +proj= string or WKT",
      ""};
}

std::optional<LatLon> ReferenceSystem::ToLatLon(double x, double y) const {
  const std::lock_guard lock(TheProj().mutex);
  return Impl::Place(impl_->transform, x, y);
}

std::optional<InexactShift> ReferenceSystem::InexactShiftAt(double x, double y) const {
  const std::lock_guard lock(TheProj().mutex);
  const std::optional<double> error_m = impl_->InexactShiftM(x, y);
  if (!error_m) return std::nullopt;
  const auto there = Impl::Place(impl_->transform, x, y);
  return InexactShift{*error_m, there && impl_->LacksGridAt(*there)};
}

std::optional<double> ReferenceSystem::InexactShiftM(const LatLon& near) const {
  const std::lock_guard lock(TheProj().mutex);
  const auto own = Impl::Brought(impl_->transform, PJ_INV, near.lon_deg, near.lat_deg);
  if (!own || !std::isfinite(own->xy.x) || !std::isfinite(own->xy.y)) return std::nullopt;
  return impl_->InexactShiftM(own->xy.x, own->xy.y);
}

bool ReferenceSystem::is_geographic() const { return impl_->is_geographic; }
double ReferenceSystem::metres_per_height_unit() const { return impl_->metres_per_height_unit; }
bool ReferenceSystem::heights_are_above_sea() const { return impl_->heights_are_above_sea; }
const AreaOfUse& ReferenceSystem::area() const { return impl_->area; }
const std::string& ReferenceSystem::definition() const { return impl_->definition; }
const std::string& ReferenceSystem::name() const { return impl_->name; }

int UtmCodeOf(const LatLon& place) {
  const double lat_deg = place.lat_deg;
  const double lon_deg = std::remainder(place.lon_deg, 360.0);
  int zone = static_cast<int>(std::floor((lon_deg + 180.0) / 6.0)) % 60 + 1;
  if (lat_deg >= 56.0 && lat_deg < 64.0 && lon_deg >= 3.0 && lon_deg < 12.0) zone = 32;
  if (lat_deg >= 72.0 && lon_deg >= 0.0 && lon_deg < 42.0) {
    zone = lon_deg < 9.0 ? 31 : lon_deg < 21.0 ? 33 : lon_deg < 33.0 ? 35 : 37;
  }
  return (lat_deg < 0.0 ? 32700 : 32600) + zone;
}

bool IsWithinUtm(const LatLon& place) { return place.lat_deg >= -80.0 && place.lat_deg <= 84.0; }

}  // namespace skyquilt::geo
