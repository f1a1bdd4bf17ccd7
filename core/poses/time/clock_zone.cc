#include "core/poses/time/clock_zone.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <limits>
#include <utility>

#include "core/base/median.h"
#include "core/poses/time/log_cover.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;

constexpr int kQuarterMin = 15, kWidestZoneMin = 14 * 60;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Where clocks are not whole hours from UTC (IANA time zone database), roughly.
struct OddZone {
  int zone_min;
  double west_deg, east_deg, south_deg, north_deg;
};
constexpr OddZone kOddZones[] = {
    {330, 68.0, 98.0, 5.0, 36.0},       // India, Sri Lanka
    {345, 80.0, 88.5, 26.0, 31.0},      // Nepal
    {390, 92.0, 101.5, 9.0, 29.0},      // Myanmar
    {210, 44.0, 63.5, 25.0, 40.0},      // Iran
    {270, 60.0, 75.0, 29.0, 39.0},      // Afghanistan
    {570, 129.0, 142.0, -38.5, -10.0},  // Northern Territory, South Australia
    {630, 129.0, 142.0, -38.5, -26.0},  // South Australia in summer
    {-210, -60.0, -52.0, 46.0, 56.0},   // Newfoundland
    {-150, -60.0, -52.0, 46.0, 56.0},   // Newfoundland in summer
};

bool IsZoneOfPlace(int zone_min, const geo::LatLon& place) {
  return std::any_of(std::begin(kOddZones), std::end(kOddZones), [&](const OddZone& odd) {
    return odd.zone_min == zone_min && place.lon_deg >= odd.west_deg && place.lon_deg <= odd.east_deg &&
           place.lat_deg >= odd.south_deg && place.lat_deg <= odd.north_deg;
  });
}

class ZoneSearch {
 public:
  ZoneSearch(const std::vector<Photo>& photos, const StampedPhotos& camera, std::span<const double> times_s,
             double as_it_stands_s, const FlightLog& log)
      : photos_(photos),
        camera_(camera),
        times_s_(times_s),
        as_it_stands_s_(as_it_stands_s),
        log_(log),
        cover_(log) {}

  std::optional<ZoneChoice> Run() {
    if (cover_.IsEmpty() || times_s_.empty()) return std::nullopt;
    std::vector<ZoneChoice> whole, standing, parts;
    for (int zone_min = -kWidestZoneMin; zone_min <= kWidestZoneMin; zone_min += kQuarterMin) {
      ZoneChoice zone;
      zone.zone_min = zone_min;
      zone.offset_s = as_it_stands_s_ - 60.0 * zone_min;
      zone.covered = static_cast<std::size_t>(std::count_if(
          times_s_.begin(), times_s_.end(), [&](double t_s) { return cover_.Covers(t_s + zone.offset_s); }));
      if (zone.covered == 0) continue;
      const bool moves = !cover_.HasTrack() || cover_.WayM(TimesIn(zone)) > kStandsWithinM;
      if (CoversNearlyAll(zone) && cover_.IsCutWhereItLacks(TimesIn(zone)))
        (moves ? whole : standing).push_back(zone);
      else if (moves)
        parts.push_back(zone);
    }
    const std::optional<ZoneChoice> part = BestPart(parts);
    if (!whole.empty()) {
      ZoneChoice choice = BestOf(std::move(whole));
      // A log that was cut, in a zone that is the likelier by itself.
      if (part && choice.decided_by.empty() && RankOf(part->zone_min) < RankOf(choice.zone_min))
        choice.open_with_min.push_back(part->zone_min);
      return choice;
    }
    // A camera that stands takes photos of one place; or the log was cut in the flight, and stood before.
    if (!part && standing.empty()) return std::nullopt;
    if (!part) return BestOf(std::move(standing));
    ZoneChoice choice = *part;
    choice.fitting = 1 + standing.size();
    for (const ZoneChoice& zone : standing) choice.open_with_min.push_back(zone.zone_min);
    return choice;
  }

 private:
  std::vector<double> TimesIn(const ZoneChoice& zone) const {
    std::vector<double> times_s(times_s_.begin(), times_s_.end());
    for (double& t_s : times_s) t_s += zone.offset_s;
    return times_s;
  }

  // Of ten photos one may fall into a moment without a fix.
  bool CoversNearlyAll(const ZoneChoice& zone) const {
    constexpr std::size_t kNearlyAll = 9, kOf = 10;
    return kOf * zone.covered >= kNearlyAll * times_s_.size();
  }

  // A log of all but a few photos on the ground, or of a part of the flight, that was cut where photos go on;
  // and no other zone comes near.
  std::optional<ZoneChoice> BestPart(const std::vector<ZoneChoice>& parts) const {
    constexpr int kHalfHourMin = 30;
    const auto best = std::max_element(parts.begin(), parts.end(),
                                       [](const auto& a, const auto& b) { return a.covered < b.covered; });
    if (best == parts.end() || 2 * best->covered <= times_s_.size() || best->zone_min % kHalfHourMin != 0)
      return std::nullopt;
    const bool is_all_but_few =
        cover_.HasTrack() && CoversNearlyAll(*best) && cover_.AreOthersOfGround(TimesIn(*best));
    for (auto other = parts.begin(); other != parts.end(); ++other) {
      const bool is_unlikelier = is_all_but_few && RankOf(other->zone_min) > RankOf(best->zone_min);
      if (other != best && !is_unlikelier && 2 * other->covered >= best->covered) return std::nullopt;
    }
    if (!is_all_but_few && !cover_.IsCutWhereItLacks(TimesIn(*best))) return std::nullopt;
    return *best;
  }

  ZoneChoice BestOf(std::vector<ZoneChoice> zones) const {
    for (ZoneChoice& zone : zones) zone.fitting = zones.size();
    std::optional<ZoneChoice> decided = Decided(zones);
    if (!decided) {
      int lowest = RankOf(zones.front().zone_min);
      for (const ZoneChoice& zone : zones) lowest = std::min(lowest, RankOf(zone.zone_min));
      std::erase_if(zones, [&](const auto& zone) { return RankOf(zone.zone_min) > lowest; });
      decided = Decided(zones);
    }
    if (decided) return *decided;
    const auto likely = std::min_element(zones.begin(), zones.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.zone_min - SunsMin()) < std::abs(b.zone_min - SunsMin());
    });
    ZoneChoice choice = *likely;
    for (const ZoneChoice& zone : zones)
      if (zone.zone_min != likely->zone_min) choice.open_with_min.push_back(zone.zone_min);
    return choice;
  }

  // The one that evidence prefers clearly; the only one.
  std::optional<ZoneChoice> Decided(const std::vector<ZoneChoice>& zones) const {
    if (zones.size() == 1) return zones.front();
    struct Evidence {
      double (ZoneSearch::*score)(const ZoneChoice&) const;
      double good, bad;
      const char* words;
    };
    constexpr double kNearM = 30.0, kFarM = 60.0;  // a receiver's error and a wrong second; clearly beyond
    constexpr double kConstantTurn = 0.9, kOtherTurn = 0.7, kMostlyEven = 0.8, kHardlyEven = 0.5;
    const Evidence witnesses[] = {
        {&ZoneSearch::Nearness, -kNearM, -kFarM, "the photos' own positions say"},
        {&ZoneSearch::HeadingFit, kConstantTurn, kOtherTurn, "the headings of the photos say"},
        {&ZoneSearch::Evenness, kMostlyEven, kHardlyEven, "the even spacing of the photos says"},
    };
    for (const Evidence& evidence : witnesses) {
      const ZoneChoice* best = nullptr;
      std::size_t bad = 0;
      for (const ZoneChoice& zone : zones) {
        const double score = (this->*evidence.score)(zone);
        if (score >= evidence.good) best = &zone;
        if (score <= evidence.bad) ++bad;
      }
      if (best == nullptr || bad + 1 != zones.size()) continue;
      ZoneChoice choice = *best;
      choice.decided_by = evidence.words;
      return choice;
    }
    return std::nullopt;
  }

  double Nearness(const ZoneChoice& zone) const {
    std::vector<double> apart_m;
    for (std::size_t k = 0; k < times_s_.size(); ++k) {
      const auto& own = photos_[camera_.photo[k]].position;
      const auto at = own ? cover_.PositionAt(times_s_[k] + zone.offset_s) : std::nullopt;
      if (at) apart_m.push_back((*at - cover_.InPlane(own->position)).norm());
    }
    return apart_m.empty() ? kUnknown : -Median(std::move(apart_m));
  }

  // 1 where the camera is always turned alike against the course, as one that looks ahead is; nothing where
  // it kept its heading whatever the course.
  double HeadingFit(const ZoneChoice& zone) const {
    constexpr std::size_t kFewest = 6;
    constexpr double kTurns = 0.9, kMovesMps = 1.0;
    std::complex<double> headings = 0.0, against_course = 0.0;
    std::size_t with_heading = 0, moving = 0;
    for (std::size_t k = 0; k < times_s_.size(); ++k) {
      const auto& attitude = photos_[camera_.photo[k]].attitude;
      if (!attitude) continue;
      ++with_heading;
      headings += std::polar(1.0, attitude->yaw_rad);
      const double t_s = times_s_[k] + zone.offset_s;
      const auto before = cover_.PositionAt(t_s - 0.5), after = cover_.PositionAt(t_s + 0.5);
      if (!before || !after || (*after - *before).norm() < kMovesMps) continue;
      const Eigen::Vector2d way = *after - *before;
      against_course += std::polar(1.0, attitude->yaw_rad - std::atan2(way.x(), way.y()));
      ++moving;
    }
    if (with_heading < kFewest || std::abs(headings) > kTurns * static_cast<double>(with_heading))
      return kUnknown;
    if (2 * moving < with_heading) return 0.0;
    return std::abs(against_course) / static_cast<double>(moving);
  }

  // The share of steps between photos that are as long as most are: a flight plan fires by the way flown.
  // Nothing where the camera fired by the clock, which makes even steps of any steady track.
  double Evenness(const ZoneChoice& zone) const {
    constexpr std::size_t kFewest = 8;
    constexpr double kShortestStepM = 2.0, kEvenTimes = 0.5;
    std::vector<double> steps_m, intervals_s;
    for (std::size_t k = 1; k < times_s_.size(); ++k) {
      intervals_s.push_back(times_s_[k] - times_s_[k - 1]);
      const auto before = cover_.PositionAt(times_s_[k - 1] + zone.offset_s);
      const auto after = cover_.PositionAt(times_s_[k] + zone.offset_s);
      if (before && after) steps_m.push_back((*after - *before).norm());
    }
    if (steps_m.size() < kFewest || ShareOfUsual(intervals_s) > kEvenTimes) return kUnknown;
    return Median(steps_m) < kShortestStepM ? 0.0 : ShareOfUsual(steps_m);
  }

  static double ShareOfUsual(const std::vector<double>& values) {
    constexpr double kAlike = 0.25;
    const double usual = Median(values);
    const auto alike = std::count_if(values.begin(), values.end(),
                                     [&](double value) { return std::abs(value - usual) <= kAlike * usual; });
    return static_cast<double>(alike) / static_cast<double>(values.size());
  }

  // The likeliest first: two local clocks stand in one zone; a place with an odd zone; whole hours.
  int RankOf(int zone_min) const {
    if (!log_.utc_at_zero && zone_min == 0) return 0;
    if (!log_.gnss.empty() && IsZoneOfPlace(zone_min, log_.gnss.front().position)) return 0;
    return zone_min % 60 == 0 ? 1 : zone_min % 30 == 0 ? 2 : 3;
  }

  int SunsMin() const {
    constexpr double kMinutesADegree = 4.0;
    if (!log_.utc_at_zero || log_.gnss.empty()) return 0;
    return static_cast<int>(std::lround(kMinutesADegree * log_.gnss.front().position.lon_deg));
  }

  const std::vector<Photo>& photos_;
  const StampedPhotos& camera_;
  std::span<const double> times_s_;
  double as_it_stands_s_;
  const FlightLog& log_;
  LogCover cover_;
};

}  // namespace

std::optional<ZoneChoice> ChooseZone(const std::vector<Photo>& photos, const StampedPhotos& camera,
                                     std::span<const double> times_s, double as_it_stands_s,
                                     const FlightLog& log) {
  return ZoneSearch(photos, camera, times_s, as_it_stands_s, log).Run();
}

std::string ZoneInWords(int zone_min) {
  const int size_min = std::abs(zone_min);
  return fmt::format("{}{:02}:{:02}", zone_min < 0 ? '-' : '+', size_min / 60, size_min % 60);
}

}  // namespace skyquilt::poses
