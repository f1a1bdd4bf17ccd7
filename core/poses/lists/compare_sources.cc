#include "core/poses/lists/compare_sources.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/poses/evidence/records_apart.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/judge_list.h"
#include "core/poses/lists/list_words.h"
#include "core/poses/lists/marked_photos.h"
#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Flight;
using flight::FlightLog;
using flight::ListFault;
using flight::ListUse;
using geo::LatLon;

using CameraPlace = std::tuple<std::string, double, double>;

CameraPlace CameraPlaceOf(const flight::Photo& photo) {
  return {photo.camera_key, photo.position->position.lat_deg, photo.position->position.lon_deg};
}

// What photos say of themselves, and whether it moves with them.
struct OwnRecords {
  std::vector<std::optional<LatLon>> moving;  // by photo
  std::optional<LatLon> anywhere;             // of the flight
  bool is_of_photos = false;                  // what they say themselves, not a track or a list
  bool is_stale = false;
};

std::optional<LatLon> PlaceOfTracks(const std::vector<FlightLog>& logs) {
  for (const FlightLog& log : logs) {
    if (!log.gnss.empty()) return log.gnss[log.gnss.size() / 2].position;
  }
  return std::nullopt;
}

OwnRecords OwnRecordsOf(const Flight& flight) {
  std::map<CameraPlace, int> at_place;
  for (const flight::Photo& photo : flight.photos) {
    if (photo.position) ++at_place[CameraPlaceOf(photo)];
  }
  OwnRecords own;
  std::vector<LatLon> moving, shared;
  for (const flight::Photo& photo : flight.photos) {
    std::optional<LatLon>& place = own.moving.emplace_back();
    if (!photo.position) continue;
    const LatLon& at = photo.position->position;
    if (at_place[CameraPlaceOf(photo)] > kMaxAtOnePlace) {
      shared.push_back(at);
      continue;
    }
    place = at;
    moving.push_back(at);
  }
  if (moving.size() < shared.size()) {  // the few that differ may be of before it was lost
    own.is_stale = true;
    std::fill(own.moving.begin(), own.moving.end(), std::nullopt);
    own.anywhere = shared.front();
  } else {
    own.anywhere = MedianPosition(moving);
  }
  own.is_of_photos = own.anywhere.has_value();
  if (!own.anywhere || own.is_stale) {
    if (const auto track = PlaceOfTracks(flight.logs)) {
      own.anywhere = track;
      own.is_stale = false;
      own.is_of_photos = false;
    }
  }
  return own;
}

struct JudgedList {
  ListUse use;
  ListVerdict verdict;
  std::vector<std::size_t> events;  // of the log: those that were judged
  std::vector<std::size_t> photos;  // that they name
  std::vector<std::size_t> others;  // events of photos that are not here
};

ListUse UseOf(const ListVerdict& verdict, const OwnRecords& own) {
  ListUse use = verdict.use;
  use.own_are_photos = own.is_of_photos;
  use.own_are_stale = own.is_stale;
  use.rows_used = static_cast<std::size_t>(std::count_if(
      verdict.places.begin(), verdict.places.end(), [](const auto& place) { return place.has_value(); }));
  return use;
}

// Nothing for a log without rows that name photos and say where they were taken.
std::optional<JudgedList> Judge(const FlightLog& log, const NamedPhotos& named, const OwnRecords& own) {
  JudgedList judged;
  WrittenList list{.system = log.written_system,
                   .order_is_named = log.written_order_is_named,
                   .order_is_assumed = log.written_order_is_assumed,
                   .is_one_of_photos = true,
                   .rows = {},
                   .others = {}};
  OwnPlaces places{.of_row = {}, .of_flight = own.anywhere, .is_stale = own.is_stale};
  std::size_t rows = 0;
  for (std::size_t i = 0; i < log.events.size(); ++i) {
    const CameraEvent& event = log.events[i];
    if (!event.written || !event.image_name) continue;
    ++rows;
    const std::vector<std::size_t> photos = named.Find(*event.image_name).photos;
    if (photos.empty()) {
      judged.others.push_back(i);
      list.others.push_back(*event.written);
      continue;
    }
    judged.events.push_back(i);
    judged.photos.push_back(photos.front());
    list.rows.push_back(*event.written);
    places.of_row.push_back(own.moving[photos.front()]);
  }
  if (rows == 0) return std::nullopt;
  if (!judged.events.empty()) judged.verdict = JudgeList(list, places);
  judged.use = UseOf(judged.verdict, own);
  if (judged.events.empty()) judged.use.fault = ListFault::kNamesNoPhoto;
  judged.use.file_name = log.file_name;
  judged.use.format = log.format;
  judged.use.system = log.written_system;
  judged.use.order_is_named = log.written_order_is_named;
  judged.use.rows = rows;
  judged.use.photos_named = judged.events.size();
  return judged;
}

void TakeReading(const JudgedList& judged, FlightLog& log) {
  const auto take = [&](const std::vector<std::size_t>& events,
                        const std::vector<std::optional<LatLon>>& places) {
    for (std::size_t k = 0; k < events.size(); ++k) {
      CameraEvent& event = log.events[events[k]];
      if (judged.use.fault == ListFault::kNone) {
        event.position = places[k];
      } else {
        event.position.reset();
        event.yaw_pitch_roll_rad.reset();
      }
    }
  };
  take(judged.events, judged.verdict.places);
  take(judged.others, judged.verdict.other_places);
}

// What one list says of photos without a position of their own is a source for the others.
void Learn(const JudgedList& judged, OwnRecords& own) {
  if (judged.use.fault != ListFault::kNone || judged.use.apart_m) return;
  for (std::size_t k = 0; k < judged.events.size(); ++k) {
    if (!own.moving[judged.photos[k]]) own.moving[judged.photos[k]] = judged.verdict.places[k];
  }
  if (!own.anywhere || own.is_stale) {
    own.anywhere = judged.verdict.middle;
    own.is_of_photos = false;
  }
  own.is_stale = false;
}

void Tell(ListUse use, Flight& flight) {
  if (auto remark = RemarkOf(use)) flight.warnings.push_back(*std::move(remark));
  if (auto remark = RemarkOnSystem(use)) flight.warnings.push_back(*std::move(remark));
  flight.list_uses.push_back(std::move(use));
}

// Those that can be read in two ways wait for what the others say.
Result<void> CompareLists(const NamedPhotos& named, OwnRecords& own, Flight& flight) {
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < flight.logs.size(); ++i) {
    FlightLog& log = flight.logs[i];
    auto judged = Judge(log, named, own);
    if (!judged) continue;
    if (judged->verdict.is_ambiguous) {
      open.push_back(i);
      continue;
    }
    TakeReading(*judged, log);
    Learn(*judged, own);
    Tell(std::move(judged->use), flight);
  }
  for (const std::size_t i : open) {
    auto judged = Judge(flight.logs[i], named, own);
    const ListVerdict& verdict = judged->verdict;
    if (verdict.is_ambiguous) {
      return Error{ErrorCode::kUnprocessable,
                   QuestionOf(judged->use, *verdict.middle, *verdict.other, *verdict.other_middle), ""};
    }
    TakeReading(*judged, flight.logs[i]);
    Learn(*judged, own);
    Tell(std::move(judged->use), flight);
  }
  return {};
}

// Where the photos that show the points were taken, else where any was.
OwnPlaces PlacesAround(const flight::GcpList& list, const NamedPhotos& named, const OwnRecords& own) {
  std::vector<LatLon> seen;
  for (const flight::GcpSighting& sighting : list.sightings) {
    const std::vector<std::size_t> photos = named.Find(sighting.image_name).photos;
    if (!photos.empty() && own.moving[photos.front()]) seen.push_back(*own.moving[photos.front()]);
  }
  OwnPlaces places{.of_row = {}, .of_flight = MedianPosition(seen), .is_stale = own.is_stale};
  if (!places.of_flight) places.of_flight = own.anywhere;
  places.of_row.resize(list.points.size());
  return places;
}

// The list where it serves.
std::optional<flight::GcpList> JudgedControl(flight::GcpList list, const NamedPhotos& named,
                                             const OwnRecords& own, Flight& flight) {
  WrittenList written{.system = list.reference_system,
                      .order_is_named = false,
                      .order_is_assumed = false,
                      .is_one_of_photos = false,
                      .rows = {},
                      .others = {}};
  for (const flight::GcpPoint& point : list.points) written.rows.push_back({point.x, point.y});
  const ListVerdict verdict = JudgeList(written, PlacesAround(list, named, own));
  ListUse use = UseOf(verdict, own);
  use.kind = flight::ListKind::kControl;
  use.file_name = list.file_name;
  use.system = list.reference_system;
  use.rows = list.points.size();
  const MarkedPhotosFound found = FindMarkedPhotos(flight.photos, named, list);
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
  Tell(std::move(use), flight);
  return *std::move(placed);
}

void CompareControl(const NamedPhotos& named, const OwnRecords& own, Flight& flight) {
  for (flight::GcpList& list : std::exchange(flight.gcp_lists, {})) {
    if (auto judged = JudgedControl(std::move(list), named, own, flight))
      flight.gcp_lists.push_back(*std::move(judged));
  }
}

}  // namespace

Result<void> CompareSources(Flight& flight) {
  OwnRecords own = OwnRecordsOf(flight);
  const NamedPhotos named(flight.photos);
  SKYQUILT_TRY(CompareLists(named, own, flight));
  CompareControl(named, own, flight);
  return {};
}

}  // namespace skyquilt::poses
