#include "core/poses/lists/judge_list.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/geo/crs/map_projection.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/crs/zoned_easting.h"
#include "core/geo/geodesic.h"
#include "core/geo/local_frame.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/evidence/records_apart.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/list_rounding.h"

namespace skyquilt::poses {
namespace {

using flight::CountsIn;
using flight::ListFault;
using flight::ListReading;
using flight::WrittenPlace;
using geo::LatLon;
using geo::MetresApart;
using Places = std::vector<std::optional<LatLon>>;

constexpr std::size_t kMaxRowsCompared = 2000;
// Two readings that differ by less are told apart by nothing that a receiver says.
constexpr double kReceiverM = 50.0;
// The wander of two receivers against each other while the flight lasts.
constexpr double kWanderM = 15.0;
constexpr double kShareOfExtent = 0.5;
constexpr double kMinExtentM = 5.0;  // photos that stand still have no layout
constexpr std::size_t kMinRowsOfShape = 4;
constexpr double kOnePlaneM = 100'000.0;  // further away no shape is compared: one plane does not hold both
// A flight, its take-off and its last fix lie within this; surveyed points are seen by the photos. Where
// these say where they were, all lie within kFarFromPhotosM; these are for one place of the flight.
constexpr double kFlightM = 50'000.0, kSurveyOfFlightM = 20'000.0;
constexpr double kMinShareOfPlaces = 0.5;
// Flights at a zone's edge are written in the neighbour's zone; the origin of a zone, where degrees taken for
// metres land, lies one and a half degrees outside.
constexpr double kAreaMarginDeg = 1.0;

struct TriedReading {
  flight::ListUse use;
  Places places;  // of the rows compared
  LatLon middle;
  bool has_other_shape = false;
};

bool MayBeDegrees(const WrittenPlace& row) { return std::abs(row.x) <= 180.0 && std::abs(row.y) <= 180.0; }

bool AreMostlyDegrees(const std::vector<WrittenPlace>& rows) {
  const auto degrees = std::count_if(rows.begin(), rows.end(), MayBeDegrees);
  return 10 * degrees >= 9 * static_cast<std::ptrdiff_t>(rows.size());
}

// Evenly, of a long list.
template <typename Value>
std::vector<Value> Thinned(const std::vector<Value>& values) {
  const std::size_t step = (values.size() + kMaxRowsCompared - 1) / kMaxRowsCompared;
  std::vector<Value> kept;
  for (std::size_t i = 0; i < values.size(); i += std::max<std::size_t>(1, step)) kept.push_back(values[i]);
  return kept;
}

// The systems that the readings of one list need, each made once.
class ListReader {
 public:
  // `near`: where the flight was, if anything says it. At a zone's edge the neighbour's counts too.
  ListReader(const std::string& system, const std::optional<LatLon>& near) {
    if (!system.empty()) {
      if (auto named = geo::ReferenceSystem::Parse(system)) named_ = *std::move(named);
    }
    for (const double aside_deg : {0.0, -kAreaMarginDeg, kAreaMarginDeg}) {
      if (!near) break;
      const double lon_deg = std::remainder(near->lon_deg + aside_deg, 360.0);
      const int code = geo::UtmCodeOf({near->lat_deg, lon_deg});
      if (!zones_.contains(code)) TakeZone(code);
    }
  }

  const std::optional<geo::ReferenceSystem>& named() const { return named_; }
  std::vector<int> utm_codes() const {
    std::vector<int> codes;
    for (const auto& [code, zone] : zones_) codes.push_back(code);
    return codes;
  }

  Places PlacesOf(const std::vector<WrittenPlace>& rows, const ListReading& reading) const {
    Places places;
    places.reserve(rows.size());
    for (const WrittenPlace& row : rows) places.push_back(PlaceOf(row, reading));
    return places;
  }

 private:
  std::optional<LatLon> PlaceOf(const WrittenPlace& row, const ListReading& reading) const {
    const double x = reading.is_swapped ? row.y : row.x;
    const double y = reading.is_swapped ? row.x : row.y;
    if (x == 0.0 && y == 0.0) return std::nullopt;  // a receiver without a fix
    if (reading.counts_in == CountsIn::kSystem) {
      return named_ ? named_->ToLatLon(geo::EastingIn(*named_, x, y), y) : std::nullopt;
    }
    if (reading.counts_in == CountsIn::kUtmOfFlight) {
      const auto zoned = geo::AsZonedEasting(x);
      const bool is_of_zone = zoned && zoned->zone == reading.utm_code % 100;
      return zones_.at(reading.utm_code).LatLonOf({is_of_zone ? zoned->east_m : x, y});
    }
    const auto place = LatLon::Make(reading.south_is_positive ? -y : y, reading.west_is_positive ? -x : x);
    return place ? std::optional<LatLon>(*place) : std::nullopt;
  }

  void TakeZone(int code) {
    if (auto zone = geo::MapProjection::OfEpsg(code)) zones_.emplace(code, *std::move(zone));
  }

  std::optional<geo::ReferenceSystem> named_;
  std::map<int, geo::MapProjection> zones_;
};

std::optional<LatLon> MiddleOf(const Places& places) {
  std::vector<LatLon> known;
  for (const std::optional<LatLon>& place : places) {
    if (place) known.push_back(*place);
  }
  return MedianPosition(known);
}

// Nothing where most rows are no places, or lie further apart than a flight does.
std::optional<TriedReading> TryReading(const ListReading& reading, const flight::ListUse& use,
                                       const std::vector<WrittenPlace>& rows, const ListReader& reader) {
  TriedReading tried;
  tried.use = use;
  tried.use.reading = reading;
  tried.places = reader.PlacesOf(rows, reading);
  const auto middle = MiddleOf(tried.places);
  if (!middle) return std::nullopt;
  std::vector<double> spread_m;
  for (const auto& place : tried.places) {
    if (place) spread_m.push_back(MetresApart(*place, *middle));
  }
  if (static_cast<double>(spread_m.size()) < kMinShareOfPlaces * static_cast<double>(rows.size()))
    return std::nullopt;
  if (Median(std::move(spread_m)) > kFlightM) return std::nullopt;
  tried.middle = *middle;
  if (reader.named()) tried.use.is_in_area = reader.named()->area().Contains(*middle, kAreaMarginDeg);
  return tried;
}

// Layout: what is left of the differences row by row when the list is shifted as a whole.
void CompareShape(const Places& own, TriedReading& tried) {
  const auto own_middle = MiddleOf(own);
  if (!own_middle || MetresApart(*own_middle, tried.middle) > kOnePlaneM) return;
  const geo::LocalFrame frame({own_middle->lat_deg, own_middle->lon_deg, 0.0});
  std::vector<Eigen::Vector2d> differences, own_at;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!own[i] || !tried.places[i]) continue;
    own_at.emplace_back(frame.EnuFromWgs84({own[i]->lat_deg, own[i]->lon_deg, 0.0}).head<2>());
    const auto& place = *tried.places[i];
    differences.emplace_back(frame.EnuFromWgs84({place.lat_deg, place.lon_deg, 0.0}).head<2>() -
                             own_at.back());
  }
  if (differences.size() < kMinRowsOfShape) return;
  // A receiver that lags behind is off to either side on lines there and back, of which the median is one.
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& difference : differences)
    mean += difference / static_cast<double>(differences.size());
  tried.use.shifted_m = std::min(mean.norm(), MedianByAxis(differences).norm());
  const auto median_length_around_median = [](const std::vector<Eigen::Vector2d>& points) {
    const Eigen::Vector2d median = MedianByAxis(points);
    std::vector<double> lengths;
    for (const Eigen::Vector2d& point : points) lengths.push_back((point - median).norm());
    return Median(std::move(lengths));
  };
  const double extent_m = median_length_around_median(own_at);
  if (extent_m < kMinExtentM) return;
  tried.use.off_shape_m = median_length_around_median(differences);
  tried.has_other_shape = *tried.use.off_shape_m > std::max(kWanderM, kShareOfExtent * extent_m);
}

void CompareWithOwn(const Places& own, const std::optional<LatLon>& of_flight, TriedReading& tried) {
  std::vector<double> apart_m;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] && tried.places[i]) apart_m.push_back(MetresApart(*own[i], *tried.places[i]));
  }
  tried.use.apart_m = MedianIfAny(std::move(apart_m));
  if (tried.use.apart_m) CompareShape(own, tried);
  if (!tried.use.apart_m && of_flight) tried.use.apart_m = MetresApart(*of_flight, tried.middle);
}

// In the order in which they are preferred: the plain one first.
std::vector<ListReading> ReadingsOf(const WrittenList& list, const ListReader& reader, bool knows_place) {
  std::vector<ListReading> readings;
  if (reader.named()) {
    readings.push_back({.counts_in = CountsIn::kSystem});
    readings.push_back({.counts_in = CountsIn::kSystem, .is_swapped = true});
  }
  const bool is_geographic = reader.named() && reader.named()->is_geographic();
  if (AreMostlyDegrees(list.rows)) {
    for (const bool south_is_positive : {false, true}) {
      for (const bool west_is_positive : {false, true}) {
        const bool is_turned = south_is_positive || west_is_positive;
        if (is_turned && (!knows_place || list.use.kind == flight::ListKind::kControl)) continue;
        for (const bool is_swapped : {false, true}) {
          if (is_geographic && !is_turned) continue;  // the named system says the same
          readings.push_back({.counts_in = CountsIn::kDegrees,
                              .is_swapped = is_swapped,
                              .west_is_positive = west_is_positive,
                              .south_is_positive = south_is_positive});
        }
      }
    }
  } else {
    for (const int utm_code : reader.utm_codes()) {
      for (const bool is_swapped : {false, true}) {
        readings.push_back(
            {.counts_in = CountsIn::kUtmOfFlight, .is_swapped = is_swapped, .utm_code = utm_code});
      }
    }
  }
  return readings;
}

const TriedReading* FindReading(const std::vector<TriedReading>& tried, const ListReading& reading) {
  const auto found = std::find_if(tried.begin(), tried.end(),
                                  [&](const TriedReading& one) { return one.use.reading == reading; });
  return found == tried.end() ? nullptr : &*found;
}

const TriedReading* NearestReading(const std::vector<TriedReading>& tried, bool with_same_shape) {
  const TriedReading* nearest = nullptr;
  for (const TriedReading& one : tried) {
    if (!one.use.apart_m || (with_same_shape && one.has_other_shape)) continue;
    if (nearest == nullptr || *one.use.apart_m < *nearest->use.apart_m) nearest = &one;
  }
  return nearest;
}

struct Choice {
  const TriedReading* reading = nullptr;
  const TriedReading* other = nullptr;  // as likely
  ListFault fault = ListFault::kNone;
};

// Others say where the flight was: the reading that agrees, the plain one where it does.
// `slack_m`: by how much the plain one may be further off than another.
Choice ChooseByAgreement(const std::vector<TriedReading>& tried, const TriedReading* plain, double far_m,
                         double slack_m) {
  const TriedReading* nearest = NearestReading(tried, true);
  if (nearest == nullptr || *nearest->use.apart_m > far_m) {
    const TriedReading* any = NearestReading(tried, false);
    const bool is_near = *any->use.apart_m <= far_m;
    return {any, nullptr, is_near ? ListFault::kOtherShape : ListFault::kFarAway};
  }
  const bool plain_agrees = plain != nullptr && plain->use.apart_m && !plain->has_other_shape &&
                            *plain->use.apart_m <= std::min(far_m, *nearest->use.apart_m + slack_m);
  return {plain_agrees ? plain : nearest, nullptr, ListFault::kNone};
}

// Nothing says where the flight was but the list: the plain reading, unless it lies outside the named
// system's area and another does not.
Choice ChooseAlone(const WrittenList& list, const ListReader& reader, const std::vector<TriedReading>& tried,
                   const TriedReading* plain) {
  // Numbers that are degrees stand, as metres, at the system's origin.
  const bool is_at_origin = reader.named() && !reader.named()->is_geographic() && AreMostlyDegrees(list.rows);
  std::vector<const TriedReading*> fitting;
  for (const TriedReading& one : tried) {
    if (one.use.is_in_area && !(is_at_origin && one.use.reading.counts_in == CountsIn::kSystem))
      fitting.push_back(&one);
  }
  if (plain != nullptr && plain->use.is_in_area && !is_at_origin) {
    ListReading turned = plain->use.reading;
    turned.is_swapped = true;
    const TriedReading* other = FindReading(tried, turned);
    const bool is_open = other != nullptr && other->use.is_in_area &&
                         MetresApart(other->middle, plain->middle) > kFlightM && !list.use.order_is_named;
    return {plain, is_open ? other : nullptr, ListFault::kNone};
  }
  if (fitting.size() == 1) return {fitting.front(), nullptr, ListFault::kNone};
  if (fitting.size() > 1) return {fitting[0], fitting[1], ListFault::kNone};
  if (plain != nullptr) return {plain, nullptr, ListFault::kNone};
  return {nullptr, nullptr, list.use.system.empty() ? ListFault::kNoSystem : ListFault::kNoPlace};
}

// Where rows count in the named system.
std::optional<geo::InexactShift> ShiftOf(const ListReader& reader, const ListReading& reading,
                                         const WrittenPlace& row) {
  if (!reader.named() || reading.counts_in != CountsIn::kSystem) return std::nullopt;
  const double x = reading.is_swapped ? row.y : row.x;
  const double y = reading.is_swapped ? row.x : row.y;
  return reader.named()->InexactShiftAt(geo::EastingIn(*reader.named(), x, y), y);
}

bool AreDegrees(const ListReader& reader, const ListReading& reading) {
  return reading.counts_in == CountsIn::kDegrees ||
         (reading.counts_in == CountsIn::kSystem && reader.named()->is_geographic());
}

// The step of the written numbers on the ground, at the row that lies at `place`.
std::optional<double> RoundedToM(const ListReader& reader, const ListReading& reading,
                                 const std::vector<WrittenPlace>& rows, const WrittenPlace& row,
                                 const LatLon& place) {
  const std::optional<double> step = FindWrittenStep(rows, AreDegrees(reader, reading));
  if (!step) return std::nullopt;
  const Places beside =
      reader.PlacesOf({WrittenPlace{row.x + *step, row.y}, WrittenPlace{row.x, row.y + *step}}, reading);
  if (!beside[0] || !beside[1]) return std::nullopt;
  const double step_m =
      std::hypot(MetresApart(place, *beside[0]), MetresApart(place, *beside[1])) / std::sqrt(2.0);
  return SigmaOfStep(step_m) > kWorstCorrectedM ? std::optional(step_m) : std::nullopt;
}

// Where the north of the plane points at the row that lies at `place`. Nothing in degrees, and in systems
// whose axes count south or west: what programs take for north there is not known.
std::optional<double> GridNorthRad(const ListReader& reader, const ListReading& reading, WrittenPlace row,
                                   const LatLon& place) {
  constexpr double kOn = 100.0, kMaxTurnedDeg = 45.0;  // metres or feet
  if (AreDegrees(reader, reading)) return std::nullopt;
  (reading.is_swapped ? row.x : row.y) += kOn;
  const std::optional<LatLon> there = reader.PlacesOf({row}, reading).front();
  if (!there) return std::nullopt;
  const geo::LocalFrame frame({place.lat_deg, place.lon_deg, 0.0});
  const Eigen::Vector3d way = frame.EnuFromWgs84({there->lat_deg, there->lon_deg, 0.0});
  const double north_rad = std::atan2(way.x(), way.y());
  return std::abs(north_rad) < geo::DegToRad(kMaxTurnedDeg) ? std::optional(north_rad) : std::nullopt;
}

}  // namespace

ListVerdict JudgeList(const WrittenList& list) {
  ListVerdict verdict;
  verdict.use = list.use;
  const Places own_compared = Thinned(list.own_of_row);
  const std::optional<LatLon> own_middle = MiddleOf(own_compared);
  const std::optional<LatLon> near = own_middle ? own_middle : list.own_of_flight;
  const ListReader reader(list.use.system, near);
  const ListReading plain_reading{.counts_in = reader.named() ? CountsIn::kSystem : CountsIn::kDegrees};
  verdict.use.reading = plain_reading;
  if (list.rows.empty()) {
    verdict.use.fault = ListFault::kNoPlace;
    return verdict;
  }
  const std::vector<WrittenPlace> rows = Thinned(list.rows);
  std::vector<TriedReading> tried;
  for (const ListReading& reading : ReadingsOf(list, reader, near.has_value())) {
    auto one = TryReading(reading, list.use, rows, reader);
    if (!one) continue;
    CompareWithOwn(own_compared, list.own_of_flight, *one);
    tried.push_back(*std::move(one));
  }
  const TriedReading* plain = FindReading(tried, plain_reading);
  if (tried.empty()) {
    const bool lacks_system = list.use.system.empty() && !AreMostlyDegrees(list.rows);
    verdict.use.fault = lacks_system ? ListFault::kNoSystem : ListFault::kNoPlace;
    return verdict;
  }
  const double flight_m = list.use.kind == flight::ListKind::kPositions ? kFlightM : kSurveyOfFlightM;
  const bool is_comparable = NearestReading(tried, false) != nullptr;
  Choice choice;
  if (is_comparable && own_middle) choice = ChooseByAgreement(tried, plain, kFarFromPhotosM, kReceiverM);
  if (is_comparable && !own_middle) choice = ChooseByAgreement(tried, plain, flight_m, flight_m);
  // A fix that all photos share may be of another day.
  const bool is_refused_by_stale = choice.fault != ListFault::kNone && !own_middle && list.use.own_are_stale;
  if (!is_comparable || is_refused_by_stale) choice = ChooseAlone(list, reader, tried, plain);
  const TriedReading* taken = choice.reading;
  if (taken != nullptr) verdict.use = taken->use;
  verdict.use.fault = choice.fault;
  if (taken == nullptr) return verdict;
  verdict.use.is_as_written = taken->use.reading == plain_reading;
  verdict.middle = taken->middle;
  if (plain != nullptr) verdict.use.as_written_apart_m = plain->use.apart_m;
  if (choice.other != nullptr) {
    // The order that a format documents is not asked for, only said.
    const bool is_documented = verdict.use.is_as_written && !list.order_is_assumed;
    verdict.is_ambiguous = !is_documented && list.use.kind == flight::ListKind::kPositions;
    verdict.other = choice.other->use.reading;
    verdict.other_middle = choice.other->middle;
    verdict.use.other_order_apart_m = MetresApart(choice.other->middle, taken->middle);
  }
  if (verdict.use.fault == ListFault::kNone) {
    verdict.places = reader.PlacesOf(list.rows, verdict.use.reading);
    const auto is_known = [](const auto& place) { return place.has_value(); };
    verdict.use.rows_used =
        static_cast<std::size_t>(std::count_if(verdict.places.begin(), verdict.places.end(), is_known));
    const auto first = std::find_if(verdict.places.begin(), verdict.places.end(), is_known);
    if (first != verdict.places.end()) {
      const WrittenPlace& row = list.rows[first - verdict.places.begin()];
      if (const auto shift = ShiftOf(reader, verdict.use.reading, row)) {
        verdict.use.system_error_m = shift->error_m;
        // No further off than where the receivers of the photos say that it lies.
        if (verdict.use.apart_m && list.use.own_are_photos && !list.use.own_are_stale)
          verdict.use.system_error_m = std::min(shift->error_m, *verdict.use.apart_m + kReceiverM);
        verdict.use.lacks_grid = shift->lacks_grid;
      }
      if (list.use.kind == flight::ListKind::kPositions)
        verdict.use.rounded_to_m = RoundedToM(reader, verdict.use.reading, list.rows, row, **first);
      verdict.grid_north_rad = GridNorthRad(reader, verdict.use.reading, row, **first);
    }
    verdict.other_places = reader.PlacesOf(list.others, verdict.use.reading);
  }
  return verdict;
}

}  // namespace skyquilt::poses
