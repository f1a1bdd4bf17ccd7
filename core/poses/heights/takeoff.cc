#include "core/poses/heights/takeoff.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/median.h"
#include "core/geo/geoid.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/log_span.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::GnssSample;

// A series at a time, between the samples around it; nothing across a hole. Tables of one row every two or
// five seconds have none.
template <typename Sample, typename Value>
std::optional<double> At(const std::vector<Sample>& samples, double t_s, Value value) {
  constexpr double kWidestGapS = 10.0;
  const Around<Sample> around = AroundTime(samples, t_s);
  if (!around.IsWithin(kWidestGapS)) return std::nullopt;
  return (1.0 - around.weight) * value(*around.before) + around.weight * value(*around.after);
}

// A sensor out of reach repeats its limit to the last digit: over it the ground would seem to lie as far
// below a flight of constant height.
std::vector<flight::RangeSample> EchoesWithinReach(std::vector<flight::RangeSample> echoes) {
  constexpr std::size_t kFewestAtLimit = 20, kOneIn = 10;
  constexpr double kOthersShorterM = 1.0;
  if (echoes.empty()) return echoes;
  const auto [nearest, farthest] = std::minmax_element(
      echoes.begin(), echoes.end(), [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  const double limit_m = farthest->distance_m;
  const auto is_at_limit = [&](const flight::RangeSample& echo) { return echo.distance_m == limit_m; };
  const auto at_limit = static_cast<std::size_t>(std::count_if(echoes.begin(), echoes.end(), is_at_limit));
  const bool is_repeated = at_limit >= kFewestAtLimit && kOneIn * at_limit >= echoes.size();
  if (is_repeated && limit_m - nearest->distance_m > kOthersShorterM) std::erase_if(echoes, is_at_limit);
  return echoes;
}

class TakeoffSearch {
 public:
  TakeoffSearch(const FlightLog& log, const std::vector<PhotoAtTime>& photos,
                const std::optional<double>& given_ellipsoid_m)
      : log_(log),
        photos_(photos),
        given_ellipsoid_m_(given_ellipsoid_m),
        echoes_(EchoesWithinReach(log.range)) {
    if (!log.gnss.empty()) geoid_m_ = geo::GeoidHeightM(log.gnss.front().position).value_or(0.0);
  }

  Takeoff Run() {
    Place();
    const bool done = ByBarometer() || ByRange() || ByPhotos() || ByBeginning();
    if (!done) Guess();
    GroundByRange();
    return std::move(out_);
  }

 private:
  std::optional<double> Ellipsoid(const GnssSample& fix) const {
    if (fix.height_ellipsoid_m) return fix.height_ellipsoid_m;
    if (fix.height_amsl_m) return *fix.height_amsl_m + geoid_m_;
    return std::nullopt;
  }

  std::optional<double> GnssHeightAt(double t_s) const {
    return At(log_.gnss, t_s, [&](const GnssSample& fix) { return Ellipsoid(fix).value_or(std::nan("")); });
  }
  std::optional<double> BaroAt(double t_s) const {
    return At(log_.baro, t_s, [](const flight::BaroSample& s) { return s.height_above_takeoff_m; });
  }

  // The middle of the photos, by the log's track or by their own positions.
  void Place() {
    std::vector<geo::LatLon> seen;
    for (const PhotoAtTime& p : photos_) {
      if (const GnssSample* fix = AroundTime(log_.gnss, p.t_s).after; fix != nullptr) {
        seen.push_back(fix->position);
      } else if (p.photo->position) {
        seen.push_back(p.photo->position->position);
      }
    }
    out_.middle = MedianPosition(seen);
    if (!log_.gnss.empty()) out_.position = log_.gnss.front().position;
  }

  bool ByBarometer() {
    if (log_.baro.empty()) return false;
    std::vector<double> zeros;
    for (const GnssSample& fix : log_.gnss) {
      const auto height_m = Ellipsoid(fix);
      const auto baro_m = BaroAt(fix.t_s);
      if (height_m && baro_m) zeros.push_back(*height_m - *baro_m);
    }
    const bool are_of_log = !zeros.empty();
    for (const PhotoAtTime& p : photos_) {
      if (are_of_log || !p.photo->position) continue;
      const auto height_m = EllipsoidHeightM(*p.photo->position);
      const auto baro_m = BaroAt(p.t_s);
      if (height_m && baro_m) zeros.push_back(*height_m - *baro_m);
    }
    out_.hangs_on_cameras = out_.is_above_ellipsoid = !zeros.empty();
    out_.height_ellipsoid_m = MedianIfAny(std::move(zeros)).value_or(0.0);
    out_.rule = "height above take-off by the log's barometer, flat ground at take-off height";
    return true;
  }

  bool ByRange() {
    if (echoes_.size() < 5) return false;
    std::vector<double> grounds;
    for (const flight::RangeSample& echo : echoes_) {
      const auto height_m = GnssHeightAt(echo.t_s);
      if (height_m && std::isfinite(*height_m)) grounds.push_back(*height_m - echo.distance_m);
    }
    if (grounds.empty() && !log_.gnss.empty()) return false;
    out_.is_above_ellipsoid = !grounds.empty();
    out_.height_ellipsoid_m = MedianIfAny(std::move(grounds)).value_or(0.0);
    out_.rule = "height above flat ground by the log's range finder";
    return true;
  }

  bool ByPhotos() {
    std::vector<double> zeros;
    for (const PhotoAtTime& p : photos_) {
      if (!p.photo->position || !p.photo->position->height_above_takeoff_m) continue;
      auto height_m = GnssHeightAt(p.t_s);
      if (!height_m) height_m = EllipsoidHeightM(*p.photo->position);
      if (height_m && std::isfinite(*height_m)) {
        zeros.push_back(*height_m - *p.photo->position->height_above_takeoff_m);
      }
    }
    const auto zero_m = MedianIfAny(std::move(zeros));
    if (!zero_m) return false;
    out_.hangs_on_cameras = out_.is_above_ellipsoid = true;
    out_.height_ellipsoid_m = *zero_m;
    out_.rule = "height above take-off as the photos record it, flat ground at take-off height";
    return true;
  }

  // A recorder that starts on the ground shows it: photos lie well above its first fixes.
  bool ByBeginning() {
    std::vector<double> first, over_photos;
    for (const GnssSample& fix : log_.gnss) {
      if (fix.t_s > log_.gnss.front().t_s + 3.0) break;
      if (const auto height_m = Ellipsoid(fix)) first.push_back(*height_m);
    }
    for (const PhotoAtTime& p : photos_) {
      const auto height_m = GnssHeightAt(p.t_s);
      if (height_m && std::isfinite(*height_m)) over_photos.push_back(*height_m);
    }
    const auto ground_m = MedianIfAny(std::move(first));
    const auto photo_m = MedianIfAny(std::move(over_photos));
    if (!ground_m || !photo_m || *photo_m - *ground_m < 8.0) return false;
    out_.hangs_on_cameras = out_.is_above_ellipsoid = true;
    out_.height_ellipsoid_m = *ground_m;
    out_.rule = "GNSS height above the place where the log begins, taken for the ground";
    return true;
  }

  void Guess() {
    std::vector<flight::Photo> photos;
    for (const PhotoAtTime& p : photos_) {
      photos.push_back(*p.photo);
      const GnssSample* fix = AroundTime(log_.gnss, p.t_s).after;
      if (fix == nullptr) continue;
      photos.back().position.emplace();
      photos.back().position->position = fix->position;
      photos.back().position->height_ellipsoid_m = Ellipsoid(*fix);
    }
    const FlightHeights heights = ChooseHeights(photos, nullptr, given_ellipsoid_m_);
    out_.hangs_on_cameras = heights.hangs_on_cameras;
    out_.is_above_ellipsoid = heights.is_above_ellipsoid;
    out_.height_ellipsoid_m = heights.takeoff_ellipsoid_m;
    out_.rule = heights.rule_in_words;
    out_.assumption = heights.assumption;
  }

  // What the range finder saw below the flight, against the barometer's zero.
  void GroundByRange() {
    // Without positions the track itself hangs on the range finder's plane.
    if (log_.baro.empty() || !out_.middle) return;
    std::vector<double> grounds;
    for (const flight::RangeSample& echo : echoes_) {
      const auto height_m = BaroAt(echo.t_s);
      if (height_m && *height_m > 3.0 && echo.distance_m > 2.0)
        grounds.push_back(*height_m - echo.distance_m);
    }
    if (grounds.size() < 20) return;
    const double ground_m = *MedianIfAny(grounds);
    std::vector<double> apart;
    apart.reserve(grounds.size());
    for (const double g : grounds) apart.push_back(std::abs(g - ground_m));
    // A sensor at its limit repeats it: the ground then seems to climb with the aircraft.
    if (*MedianIfAny(std::move(apart)) > 2.0) return;
    out_.ground_above_takeoff_m = ground_m;
    out_.rule += fmt::format("; the range finder puts the ground {:+.1f} m from take-off", ground_m);
  }

  const FlightLog& log_;
  const std::vector<PhotoAtTime>& photos_;
  const std::optional<double>& given_ellipsoid_m_;
  const std::vector<flight::RangeSample> echoes_;
  double geoid_m_ = 0.0;
  Takeoff out_;
};

}  // namespace

Takeoff FindTakeoff(const FlightLog& log, const std::vector<PhotoAtTime>& photos,
                    const std::optional<double>& given_ellipsoid_m) {
  return TakeoffSearch(log, photos, given_ellipsoid_m).Run();
}

}  // namespace skyquilt::poses
