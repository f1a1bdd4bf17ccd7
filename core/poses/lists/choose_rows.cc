#include "core/poses/lists/choose_rows.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geodesic.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Flight;
using flight::FlightLog;
using flight::Remark;
using flight::RemarkCode;
using geo::LatLon;

// Two lists that differ by more of their sigmas than this do not say the same.
constexpr double kAgreeSigmas = 3.0;
// What the same place differs by when it is written with other digits.
constexpr double kSamePlaceM = 0.1;
// Rows of one photo in one list that are looked at; who joins solutions has a few.
constexpr std::size_t kMaxPasses = 16;

// The n-th rows that one list has of its photos: a file that holds two solutions is two lists.
struct ListPass {
  std::size_t log = 0;
  std::size_t pass = 0;

  auto operator<=>(const ListPass&) const = default;
};

struct Row {
  ListPass from;
  std::size_t event = 0;
};

using Contest = std::vector<ListPass>;
using LogAndEvent = std::pair<std::size_t, std::size_t>;
using RowsOfPhoto = std::vector<Row>;

// What two lists say of the photos that both name.
struct Disagreement {
  std::vector<double> apart_m, allowed_m;  // by photo
  RemarkCode why = RemarkCode::kHoldsByNothing;
};

bool HasTrack(const std::vector<FlightLog>& logs) {
  return std::any_of(logs.begin(), logs.end(), [](const FlightLog& log) { return log.gnss.size() >= 2; });
}

class Chooser {
 public:
  Chooser(const std::vector<std::optional<LatLon>>& own, Flight& flight) : own_(own), flight_(flight) {}

  void Gather(const NamedPhotos& named) {
    rows_of_.resize(flight_.photos.size());
    const bool has_track = HasTrack(flight_.logs);
    for (std::size_t l = 0; l < flight_.logs.size(); ++l) {
      const FlightLog& log = flight_.logs[l];
      const std::vector<NamedPhotos::Found> found = named.FindAll(log);
      std::map<std::size_t, std::size_t> passes;  // by photo
      for (std::size_t e = 0; e < log.events.size(); ++e) {
        const CameraEvent& event = log.events[e];
        if (!event.image_name || !event.position) continue;
        // Beside a track only surveyed rows with times are taken for positions.
        if (event.has_time && has_track && !event.is_rtk_fixed) continue;
        for (const std::size_t photo : found[e].photos) {
          const std::size_t pass = passes[photo]++;
          if (pass < kMaxPasses)
            rows_of_[photo].push_back({{l, pass}, e});
          else
            beyond_.emplace_back(l, e);
        }
      }
    }
  }

  void Choose() {
    std::map<Contest, std::vector<std::size_t>> photos_of;
    for (std::size_t photo = 0; photo < rows_of_.size(); ++photo) {
      if (rows_of_[photo].size() < 2) continue;
      Contest contest;
      for (const Row& row : Best(rows_of_[photo])) contest.push_back(row.from);
      photos_of[contest].push_back(photo);
    }
    for (const auto& [contest, photos] : photos_of) Decide(contest, photos);
    DropLosers();
    Tell();
  }

 private:
  const CameraEvent& EventOf(const Row& row) const { return flight_.logs[row.from.log].events[row.event]; }

  // Those that are corrected, where any is.
  RowsOfPhoto Best(const RowsOfPhoto& rows) const {
    RowsOfPhoto best;
    for (const Row& row : rows) {
      if (IsCorrected(EventOf(row))) best.push_back(row);
    }
    return best.empty() ? rows : best;
  }

  const Row& RowFrom(const ListPass& from, std::size_t photo) const {
    return *std::lower_bound(rows_of_[photo].begin(), rows_of_[photo].end(), from,
                             [](const Row& row, const ListPass& wanted) { return row.from < wanted; });
  }

  double SigmaM(const ListPass& from, const std::vector<std::size_t>& photos) const {
    std::vector<double> sigmas_m;
    for (const std::size_t photo : photos) sigmas_m.push_back(SigmaOfRowM(EventOf(RowFrom(from, photo))));
    return Median(std::move(sigmas_m));
  }

  // From the photos' own positions; of photos without any the same for all.
  double ApartM(const ListPass& from, const std::vector<std::size_t>& photos) const {
    std::vector<double> apart_m;
    for (const std::size_t photo : photos) {
      if (own_[photo])
        apart_m.push_back(geo::MetresApart(*own_[photo], *EventOf(RowFrom(from, photo)).position));
    }
    return MedianIfAny(std::move(apart_m)).value_or(std::numeric_limits<double>::infinity());
  }

  // The row itself, or that of another file of the exposure, or of another band, in the same list.
  bool HoldsWith(const Row& holding, const Row& row) const {
    if (row.from == holding.from) return true;
    const CameraEvent &held = EventOf(holding), &other = EventOf(row);
    return row.from.log == holding.from.log && other.image_name != held.image_name &&
           geo::MetresApart(*held.position, *other.position) <= kOneExposureM;
  }

  // All photos hang on the same one.
  void Decide(const Contest& contest, const std::vector<std::size_t>& photos) {
    // Where nothing tells, what is written does, so that no name of a file decides.
    using Rank = std::tuple<double, double, double, double>;
    const auto rank_of = [&](const ListPass& from) {
      const LatLon& first = *EventOf(RowFrom(from, photos.front())).position;
      return Rank{SigmaM(from, photos), ApartM(from, photos), first.lat_deg, first.lon_deg};
    };
    ListPass best = contest.front();
    Rank best_rank = rank_of(best);
    for (const ListPass& from : contest) {
      if (const Rank rank = rank_of(from); rank < best_rank)
        std::tie(best, best_rank) = std::pair(from, rank);
    }
    for (const std::size_t photo : photos) {
      const Row& holding = RowFrom(best, photo);
      holds_.emplace(photo, holding);
      for (const Row& other : rows_of_[photo]) {
        if (!HoldsWith(holding, other)) Compare(holding, other, best_rank, rank_of);
      }
    }
  }

  template <typename Rank, typename RankOf>
  void Compare(const Row& holding, const Row& other, const Rank& best_rank, const RankOf& rank_of) {
    const CameraEvent &held = EventOf(holding), &lost = EventOf(other);
    auto [found, is_new] = disagreements_.try_emplace({holding.from.log, other.from.log});
    Disagreement& disagreement = found->second;
    disagreement.apart_m.push_back(geo::MetresApart(*held.position, *lost.position));
    disagreement.allowed_m.push_back(kAgreeSigmas * std::hypot(SigmaOfRowM(held), SigmaOfRowM(lost)));
    if (!is_new) return;
    if (IsCorrected(held) != IsCorrected(lost)) {
      disagreement.why = RemarkCode::kHoldsByAccuracy;
      return;
    }
    const Rank rank = rank_of(other.from);
    if (std::get<0>(best_rank) < std::get<0>(rank))
      disagreement.why = RemarkCode::kHoldsByAccuracy;
    else if (std::get<1>(best_rank) < std::get<1>(rank))
      disagreement.why = RemarkCode::kHoldsByNearness;
  }

  void DropLosers() {
    std::map<LogAndEvent, bool> holds_any;       // of rows in contests
    std::map<std::size_t, std::size_t> held_by;  // logs, by log that lost rows
    for (const LogAndEvent& at : beyond_) holds_any.emplace(at, false);
    for (const auto& [photo, holding] : holds_) {
      for (const Row& row : rows_of_[photo]) {
        const bool is_held = HoldsWith(holding, row);
        bool& holds = holds_any[{row.from.log, row.event}];
        holds = holds || is_held;
        if (is_held) continue;
        if (row.from.log != holding.from.log) held_by.try_emplace(row.from.log, holding.from.log);
        const CameraEvent& held = EventOf(holding);
        CameraEvent& lost = flight_.logs[row.from.log].events[row.event];
        if (held.yaw_pitch_roll_rad && !held.has_time && !lost.has_time) lost.yaw_pitch_roll_rad.reset();
      }
    }
    std::map<std::size_t, std::size_t> lost_rows;  // by log
    for (const auto& [at, holds] : holds_any) {
      if (holds) continue;
      ++lost_rows[at.first];
      CameraEvent& lost = flight_.logs[at.first].events[at.second];
      // A row with a time is written over this one, once its log is tied to the photos.
      const auto holder = held_by.find(at.first);
      const bool is_overruled_later =
          !lost.has_time && holder != held_by.end() && HasTimedEvents(flight_.logs[holder->second]);
      if (!is_overruled_later) lost.position.reset();
    }
    for (flight::ListUse& use : flight_.list_uses) {
      if (use.kind != flight::ListKind::kPositions) continue;
      for (const auto& [log, rows] : lost_rows) {
        if (flight_.logs[log].file_name != use.file_name) continue;
        use.rows_used -= std::min(use.rows_used, rows);
        if (const auto holder = held_by.find(log); holder != held_by.end())
          use.held_by = flight_.logs[holder->second].file_name;
      }
    }
  }

  void Tell() {
    for (const auto& [logs, disagreement] : disagreements_) {
      const std::string& file = flight_.logs[logs.first].file_name;
      if (logs.first == logs.second) {
        std::vector<double> apart_m;
        for (const double m : disagreement.apart_m) {
          if (m > kSamePlaceM) apart_m.push_back(m);
        }
        if (apart_m.empty()) continue;
        const std::size_t rows = apart_m.size();
        flight_.warnings.push_back(
            {RemarkCode::kListRowsTwice,
             {{"file", file}, {"rows", rows}, {"apart_m", Median(std::move(apart_m))}}});
        continue;
      }
      const double apart_m = Median(disagreement.apart_m);
      if (apart_m <= Median(disagreement.allowed_m)) continue;
      flight_.warnings.push_back({RemarkCode::kListsApart,
                                  {{"file", file},
                                   {"other", flight_.logs[logs.second].file_name},
                                   {"photos", disagreement.apart_m.size()},
                                   {"apart_m", apart_m},
                                   {"why", Remark(disagreement.why)}}});
    }
  }

  const std::vector<std::optional<LatLon>>& own_;
  Flight& flight_;
  std::vector<RowsOfPhoto> rows_of_;  // by photo, each in the order of lists and rows
  std::vector<LogAndEvent> beyond_;  // rows that are not looked at, since others of their list name the photo
  std::map<std::size_t, Row> holds_;                                           // of photos with several
  std::map<std::pair<std::size_t, std::size_t>, Disagreement> disagreements_;  // by log that holds, and other
};

}  // namespace

void ChooseRows(const NamedPhotos& named, const std::vector<std::optional<LatLon>>& own, Flight& flight) {
  Chooser chooser(own, flight);
  chooser.Gather(named);
  chooser.Choose();
}

}  // namespace skyquilt::poses
