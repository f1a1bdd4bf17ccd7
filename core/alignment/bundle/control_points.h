// Ground control in the adjustment: points become observations (TieToControl), are believed less where the
// photos cannot be bent to them, and are reported: how well each fits, and how well the map knows it without
// being told (PredictControl). Heights count relative to each other: survey and drone seldom share their
// zero. Pure; any thread.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/ground_control.h"
#include "core/alignment/scene/photo_set.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/evidence/records_apart.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// The photos of a flight by their names, which marks have by now (core/poses/lists/marked_photos.h).
class MarkedPhotos {
 public:
  // `tied`: held by others; marks in the rest tell nothing of the block.
  MarkedPhotos(const std::vector<std::string>& names, const std::vector<View>& views,
               const PhotoSet& tied);  // keeps references to all three

  // The point's marks in photos that are tied; 0 where too few of them are.
  std::size_t TiedMarksOf(const ControlPoint& point) const;

  // The point's marks, and where they meet; nothing, and the reason in `told`, when they do not. A mark that
  // the others contradict is left out, which `told` says as well.
  std::optional<Track> TrackOf(const ControlPoint& point, ControlReport& told) const;

  // How far each of the point's marks lies from where its photo shows `point_in_enu`; of all photos, tied or
  // not. `used`: the marks by which the point is known.
  std::vector<ControlMarkReport> ResidualsOf(const ControlPoint& point, const Eigen::Vector3d& point_in_enu,
                                             const std::optional<Track>& used) const;

 private:
  std::vector<Observation> MarksOf(const ControlPoint& point) const;  // of all photos, tied or not

  const std::vector<std::string>& names_;
  const std::vector<View>& views_;
  const PhotoSet& tied_;
  std::map<std::string, int> number_of_;
};

// Heights of exactly 0 that were not filled in: those whose points the photos show elsewhere than beside two
// others or more, by as much as makes a height wrong. By how much, by point; nothing: it is a height, or
// there is none. Surveyed and shown above any zero each.
std::vector<std::optional<double>> HeightsLeftEmpty(const std::vector<std::optional<double>>& surveyed_m,
                                                    const std::vector<double>& shown_m);

// Of so many points that most agree on, the others tell by themselves which is wrong.
inline constexpr std::size_t kEnoughToVote = 4;

// How far the recorded positions of the photos in `tied` lie from `centers_in_enu`, where a block has them.
std::optional<poses::RecordsApart> RecordsApartOfBlock(const poses::PosedFlight& posed, const PhotoSet& tied,
                                                       const std::vector<Eigen::Vector3d>& centers_in_enu);

// What the photos refute of surveyed points before a flight is tied to them leaves `problem.control`, and
// its reports say why: lists whose marks are pixels of other pictures, lists that lie where the flight was
// not, and, among points too few to vote, the one that the photos' positions speak against. `marks_tied`: by
// point of `control`, of its marks in photos that are tied to others; 0 of a point that has too few of them.
void RefuseControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                   const std::vector<std::size_t>& marks_tied, const PhotoSet& tied, BundleProblem& problem,
                   std::vector<ControlReport>& reports);

// Moves the block to the points, so that the adjustment starts near. `problem` has been adjusted without
// control. A point needs two sightings in photos that are tied to others.
// One that lies far off where the others put the block is not used, and its report says so; nor is what the
// photos or their positions refute.
void TieToControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                  BundleProblem& problem, std::vector<ControlReport>& reports);

// Survey and photos that still are this far apart after the adjustment contradict each other.
inline constexpr double kNoSurveyM = 0.25;
inline constexpr double kNoSurveyUpM = 0.5;         // of heights, which photos from above know half as well
inline constexpr std::size_t kMinContradicted = 3;  // points, for a verdict on all of them

// Points that the photos cannot be bent to are worth no more than their residuals: more would bend the map
// and make nothing true. For a problem adjusted with control; false, and nothing done, where the survey
// holds.
bool BelieveContradictedControlLess(BundleProblem& problem);

void ReportControl(const BundleProblem& problem, std::vector<ControlReport>& reports);

// What the user is to know of surveyed points.
std::vector<flight::Remark> RemarksOn(const std::vector<ControlReport>& points);

// How well an adjusted flight knows places that it was not told: each surveyed point is left out in turn, the
// flight adjusted by the others from where it stands, and the point compared with where its marks then meet
// (leave-one-out cross-validation). Nothing is said of fewer than kMinPredictedPoints points, nor where that
// many adjustments would take too long, nor of a point without which the adjustment fails. Memory: one more
// problem. `problem`: adjusted with control; reports by BundleControl::report.
void PredictControl(const BundleProblem& problem, std::vector<ControlReport>& reports);

}  // namespace skyquilt::alignment
