#include "core/poses/lists/compare_sources.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/base/try.h"
#include "core/flight/bytes/gps_time.h"
#include "core/flight/remarks/because.h"
#include "core/geo/geodesic.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/choose_rows.h"
#include "core/poses/lists/judge_list.h"
#include "core/poses/lists/list_rounding.h"
#include "core/poses/lists/list_words.h"
#include "core/poses/lists/marked_photos.h"
#include "core/poses/lists/named_photos.h"
#include "core/poses/lists/own_records.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Flight;
using flight::FlightLog;
using flight::ListFault;
using flight::ListUse;
using geo::LatLon;

struct JudgedList : ListVerdict {
  std::vector<std::size_t> events;         // of the log: those that were judged
  std::vector<std::size_t> photos;         // that they name
  std::vector<std::size_t> others;         // events of photos that are not here
  std::vector<std::size_t> contradicting;  // of `events`: those that say of a photo what another row does not
};

// Rows of other names that give one photo other places: of two cards of which one is here, say. Nothing tells
// which of them is true.
void DropContradicting(const FlightLog& log, JudgedList& judged) {
  if (judged.places.empty()) return;
  std::map<std::size_t, std::size_t> first_of;  // by photo
  std::set<std::size_t> doubted;                // photos
  for (std::size_t k = 0; k < judged.events.size(); ++k) {
    const auto& place = judged.places[k];
    if (!place) continue;
    const std::size_t first = first_of.try_emplace(judged.photos[k], k).first->second;
    const bool is_other_name =
        log.events[judged.events[first]].image_name != log.events[judged.events[k]].image_name;
    if (is_other_name && geo::MetresApart(*judged.places[first], *place) > kOneExposureM)
      doubted.insert(judged.photos[k]);
  }
  for (std::size_t k = 0; k < judged.events.size(); ++k) {
    if (!doubted.contains(judged.photos[k]) || !judged.places[k]) continue;
    judged.places[k].reset();
    judged.contradicting.push_back(judged.events[k]);
    --judged.use.rows_used;
  }
}

// The median of how far the times of a list lie from those that a receiver told its photos, in days; nothing
// where no clock is off by so much.
std::optional<double> DaysApart(const FlightLog& log, const JudgedList& judged,
                                const std::vector<flight::Photo>& photos) {
  constexpr double kDayS = 86'400.0, kMaxClockDays = 1.0;
  if (!log.utc_at_zero) return std::nullopt;
  std::vector<double> apart_days;
  for (std::size_t k = 0; k < judged.events.size(); ++k) {
    const CameraEvent& event = log.events[judged.events[k]];
    const flight::Photo& photo = photos[judged.photos[k]];
    if (!event.has_time || !photo.receiver_time) continue;
    const double apart_s = flight::SecondsBetween(*photo.receiver_time, *log.utc_at_zero) + event.t_s;
    apart_days.push_back(std::abs(std::remainder(apart_s, flight::kGpsWeeksRunOverS)) / kDayS);
  }
  const std::optional<double> days = MedianIfAny(std::move(apart_days));
  return days && *days > kMaxClockDays ? days : std::nullopt;
}

// Of another flight by its times: nothing is believed of it where anything else places this one.
void DoubtByTime(const FlightLog& log, const std::vector<flight::Photo>& photos, const OwnRecords& own,
                 JudgedList& judged) {
  judged.use.apart_days = DaysApart(log, judged, photos);
  const bool is_placed_otherwise = own.anywhere && !own.is_stale;
  if (!judged.use.apart_days || !is_placed_otherwise || judged.use.fault != ListFault::kNone) return;
  judged.use.fault = ListFault::kOtherTime;
  judged.use.rows_used = 0;
  judged.is_ambiguous = false;
}

// Nothing for a log without rows that name photos and say where they were taken.
std::optional<JudgedList> Judge(const FlightLog& log, const std::vector<flight::Photo>& photos,
                                const NamedPhotos& named, const OwnRecords& own) {
  JudgedList judged;
  WrittenList list;
  list.use.file_name = log.file_name;
  list.use.format = log.format;
  list.use.system = log.written_system;
  list.use.order_is_named = log.written_order_is_named;
  list.use.own_are_photos = own.is_of_photos;
  list.use.own_are_stale = own.is_stale;
  list.order_is_assumed = log.written_order_is_assumed;
  list.own_of_flight = own.anywhere;
  const std::vector<NamedPhotos::Found> found = named.FindAll(log);
  for (std::size_t i = 0; i < log.events.size(); ++i) {
    const CameraEvent& event = log.events[i];
    if (!event.written || !event.image_name) continue;
    ++list.use.rows;
    const std::vector<std::size_t>& called = found[i].photos;
    if (called.empty()) {
      judged.others.push_back(i);
      list.others.push_back(*event.written);
      continue;
    }
    judged.events.push_back(i);
    judged.photos.push_back(called.front());
    list.rows.push_back(*event.written);
    list.own_of_row.push_back(own.moving[called.front()]);
  }
  if (list.use.rows == 0) return std::nullopt;
  judged.use = list.use;
  if (judged.events.empty())
    judged.use.fault = ListFault::kNamesNoPhoto;
  else
    static_cast<ListVerdict&>(judged) = JudgeList(list);
  DropContradicting(log, judged);
  DoubtByTime(log, photos, own, judged);
  return judged;
}

// Whether any row claimed to be better than the numbers that it is written in.
bool WidenRounded(const JudgedList& judged, FlightLog& log) {
  if (!judged.use.rounded_to_m) return false;
  bool any = false;
  for (const auto* const events : {&judged.events, &judged.others}) {
    for (const std::size_t i : *events) any = WidenToStep(*judged.use.rounded_to_m, log.events[i]) || any;
  }
  return any;
}

void TakeReading(const JudgedList& judged, FlightLog& log) {
  const auto take = [&](const std::vector<std::size_t>& events,
                        const std::vector<std::optional<LatLon>>& places) {
    for (std::size_t k = 0; k < events.size(); ++k) {
      CameraEvent& event = log.events[events[k]];
      if (judged.use.fault == ListFault::kNone) {
        event.position = places[k];
        event.system_error_m = judged.use.system_error_m;
        if (event.yaw_pitch_roll_rad && event.yaw_is_from_grid_north)
          event.yaw_pitch_roll_rad->x() += judged.grid_north_rad.value_or(0.0);
        if (std::binary_search(judged.contradicting.begin(), judged.contradicting.end(), events[k]))
          event.yaw_pitch_roll_rad.reset();
      } else {
        event.position.reset();
        event.yaw_pitch_roll_rad.reset();
      }
    }
  };
  take(judged.events, judged.places);
  take(judged.others, judged.other_places);
}

// What one list says of photos without a position of their own is a source for the others.
void Learn(const JudgedList& judged, OwnRecords& own) {
  if (judged.use.fault != ListFault::kNone || judged.use.apart_m) return;
  for (std::size_t k = 0; k < judged.events.size(); ++k) {
    if (!own.moving[judged.photos[k]]) own.moving[judged.photos[k]] = judged.places[k];
  }
  if (!own.anywhere || own.is_stale) {
    own.anywhere = judged.middle;
    own.is_of_photos = false;
  }
  own.is_stale = false;
}

// Of a list that serves.
void TellContradicting(const JudgedList& judged, const FlightLog& log, Flight& flight) {
  if (judged.use.fault != ListFault::kNone || judged.contradicting.empty()) return;
  flight.warnings.push_back({flight::RemarkCode::kListRowsContradict,
                             {{"file", log.file_name},
                              {"rows", judged.contradicting.size()},
                              {"first", *log.events[judged.contradicting.front()].image_name}}});
}

void Tell(ListUse use, Flight& flight) {
  if (auto remark = RemarkOf(use)) flight.warnings.push_back(*std::move(remark));
  if (auto remark = RemarkOnSystem(use)) flight.warnings.push_back(*std::move(remark));
  if (auto remark = RemarkOnRounding(use)) flight.warnings.push_back(*std::move(remark));
  flight.list_uses.push_back(std::move(use));
}

void TakeList(JudgedList judged, FlightLog& log, OwnRecords& own, Flight& flight) {
  TakeReading(judged, log);
  if (!WidenRounded(judged, log)) judged.use.rounded_to_m.reset();
  TellContradicting(judged, log, flight);
  Learn(judged, own);
  if (auto remark = RemarkOnUnit(judged.use, judged.middle)) flight.warnings.push_back(*std::move(remark));
  if (auto remark = RemarkOnHalf(judged.use, judged.middle)) flight.warnings.push_back(*std::move(remark));
  Tell(std::move(judged.use), flight);
}

// Those that can be read in two ways, or seem to be of another flight, wait for what the others say.
Result<void> CompareLists(const NamedPhotos& named, OwnRecords& own, Flight& flight) {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < flight.logs.size(); ++i) {
    auto judged = Judge(flight.logs[i], flight.photos, named, own);
    if (!judged) continue;
    if (judged->is_ambiguous || judged->use.apart_days)
      open.push_back(i);
    else
      TakeList(*std::move(judged), flight.logs[i], own, flight);
  }
  for (const std::size_t i : open) {
    auto judged = Judge(flight.logs[i], flight.photos, named, own);
    if (judged->is_ambiguous) {
      return Error{ErrorCode::kUnprocessable,
                   QuestionOf(judged->use, *judged->middle, *judged->other, *judged->other_middle), ""};
    }
    TakeList(*std::move(judged), flight.logs[i], own, flight);
  }
  return {};
}

// Where the photos that show the points were taken, else where any was.
std::optional<LatLon> PlaceAround(const MarkedPhotosFound& found, const OwnRecords& own) {
  std::vector<LatLon> seen;
  for (const std::size_t photo : found.photos) {
    if (own.moving[photo]) seen.push_back(*own.moving[photo]);
  }
  return seen.empty() ? own.anywhere : MedianPosition(seen);
}

// The list where it serves.
std::optional<flight::GcpList> JudgedControl(flight::GcpList list, const NamedPhotos& named,
                                             const OwnRecords& own, Flight& flight) {
  const MarkedPhotosFound found = FindMarkedPhotos(flight.photos, named, list);
  WrittenList written;
  written.use.kind = flight::ListKind::kControl;
  written.use.file_name = list.file_name;
  written.use.system = list.reference_system;
  written.use.rows = list.points.size();
  written.use.own_are_photos = own.is_of_photos;
  written.use.own_are_stale = own.is_stale;
  written.own_of_flight = PlaceAround(found, own);
  for (const flight::GcpPoint& point : list.points) written.rows.push_back({point.x, point.y});
  ListVerdict verdict = JudgeList(written);
  ListUse& use = verdict.use;
  use.marks = found.marks;
  use.marks_outside = found.outside;
  if (use.fault == ListFault::kNone && found.AreOfOtherPictures()) use.fault = ListFault::kOtherPixels;
  // A survey is good to centimetres, a guessed datum to metres: its system is asked for.
  if (use.system.empty()) use.fault = ListFault::kNoSystem;
  if (use.fault != ListFault::kNone) {
    use.rows_used = 0;
    Tell(std::move(use), flight);
    return std::nullopt;
  }
  list.system_error_m = use.system_error_m;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    list.points[i].has_position = verdict.places[i].has_value();
    if (verdict.places[i]) list.points[i].position = *verdict.places[i];
  }
  const std::size_t told = list.warnings.size();
  auto placed = flight::OnlyPlaced(std::move(list));
  if (!placed) {
    flight.warnings.push_back({flight::RemarkCode::kFileNotRead, {{"why", flight::WhyOf(placed.error())}}});
    return std::nullopt;
  }
  for (std::size_t i = told; i < placed->warnings.size(); ++i)
    flight.warnings.push_back(
        {flight::RemarkCode::kOfFile, {{"file", placed->file_name}, {"said", placed->warnings[i]}}});
  flight.warnings.insert(flight.warnings.end(), found.remarks.begin(), found.remarks.end());
  if (auto remark = RemarkOnHalf(use, verdict.middle)) flight.warnings.push_back(*std::move(remark));
  Tell(std::move(use), flight);
  return *std::move(placed);
}

// Written with other digits, or in another system.
bool AreSame(const flight::GcpPoint& a, const flight::GcpPoint& b) {
  constexpr double kSameM = 0.1;
  if (!a.has_position || !b.has_position || flight::IsCheckPoint(a.name) != flight::IsCheckPoint(b.name))
    return false;
  const bool have_same_height =
      a.height_m && b.height_m ? std::abs(*a.height_m - *b.height_m) <= kSameM : a.height_m == b.height_m;
  return have_same_height && geo::MetresApart(a.position, b.position) <= kSameM;
}

std::vector<flight::GcpSighting> MarksByPhoto(const flight::GcpList& list) {
  std::vector<flight::GcpSighting> marks = list.sightings;
  std::sort(marks.begin(), marks.end(), [](const flight::GcpSighting& a, const flight::GcpSighting& b) {
    return std::tie(a.image_name, a.pixel_x, a.pixel_y) < std::tie(b.image_name, b.pixel_x, b.pixel_y);
  });
  return marks;
}

// Of lists whose marks are named by the photos that they are in.
bool AreSame(const flight::GcpList& a, const flight::GcpList& b) {
  if (a.reference_system == b.reference_system && a.points == b.points && a.sightings == b.sightings)
    return true;
  if (a.sightings.empty() || a.points.size() != b.points.size()) return false;
  const auto of_a = MarksByPhoto(a), of_b = MarksByPhoto(b);
  return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                    [&](const flight::GcpSighting& one, const flight::GcpSighting& other) {
                      return one.image_name == other.image_name && one.pixel_x == other.pixel_x &&
                             one.pixel_y == other.pixel_y &&
                             AreSame(a.points[one.point], b.points[other.point]);
                    });
}

// A list that is there twice counts once: its points would bear each other out, and one that is wrong itself.
// The same bytes in two folders may mark the photos of each.
void CompareControl(const NamedPhotos& named, const OwnRecords& own, Flight& flight) {
  std::vector<flight::GcpList> before;
  for (flight::GcpList& list : std::exchange(flight.gcp_lists, {})) {
    flight::GcpList marked = list;
    FindMarkedPhotos(flight.photos, named, marked);
    const auto same = std::find_if(before.begin(), before.end(),
                                   [&](const flight::GcpList& other) { return AreSame(marked, other); });
    if (same != before.end()) {
      flight.warnings.push_back(
          {flight::RemarkCode::kSameFile, {{"file", list.file_name}, {"other", same->file_name}}});
      continue;
    }
    before.push_back(std::move(marked));
    if (auto judged = JudgedControl(std::move(list), named, own, flight))
      flight.gcp_lists.push_back(*std::move(judged));
  }
}

void WidenRoundedTracks(Flight& flight) {
  for (FlightLog& log : flight.logs) {
    if (const auto step_m = WidenToStep(log.gnss))
      flight.warnings.push_back(
          {flight::RemarkCode::kListRounded, {{"file", log.file_name}, {"step_m", *step_m}}});
  }
}

}  // namespace

Result<void> CompareSources(Flight& flight) {
  WidenRoundedTracks(flight);
  OwnRecords own = OwnRecordsOf(flight.photos, flight.logs);
  const auto own_of_photos = own.moving;  // the lists add to it
  const NamedPhotos named(flight.photos);
  SKYQUILT_TRY(CompareLists(named, own, flight));
  ChooseRows(named, own_of_photos, flight);
  CompareControl(named, own, flight);
  return {};
}

}  // namespace skyquilt::poses
