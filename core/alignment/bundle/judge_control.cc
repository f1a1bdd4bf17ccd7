#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/alignment/bundle/control_points.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using flight::Remark;
using flight::RemarkCode;

constexpr std::size_t kFewestJudgedMarks = 4;
// Pixels of a picture of half the size meet at twice the depth of what the photo shows there, of double size
// at half of it; relief and towers do not do so to most points of a list.
constexpr double kOffGroundShare = 0.25;
constexpr double kNearShare = 0.1;  // of a photo's width, from a mark to a point that photos share

// How deep photos see the ground, by the points they share with others.
class GroundSeen {
 public:
  GroundSeen(const BundleProblem& problem, const std::vector<View>& views) : views_(views) {
    PhotoSet marked(views.size());
    for (const BundleControl& tied : problem.control) {
      for (const Observation& mark : tied.track.observations) marked.Add(mark.photo);
    }
    seen_.resize(views.size());
    for (const Track& track : problem.tracks) {
      for (const Observation& one : track.observations) {
        if (marked.Has(one.photo))
          seen_[one.photo].push_back({one.pixel_in_image, DepthM(one.photo, track.point_in_enu)});
      }
    }
  }

  // Do most of the marks meet far above or below what their photos show around them?
  bool IsOff(const Track& track) const {
    int judged = 0, off = 0;
    for (const Observation& mark : track.observations) {
      const std::optional<double> ground_m = DepthNearM(mark);
      if (!ground_m || *ground_m <= 0.0) continue;
      ++judged;
      off += std::abs(DepthM(mark.photo, track.point_in_enu) / *ground_m - 1.0) > kOffGroundShare ? 1 : 0;
    }
    return 2 * off > judged;
  }

 private:
  struct Seen {
    Vector2d pixel_in_image;
    double depth_m = 0.0;
  };

  double DepthM(int photo, const Vector3d& point_in_enu) const {
    return (views_[photo].cam_from_enu * point_in_enu).z();
  }

  std::optional<double> DepthNearM(const Observation& mark) const {
    std::optional<double> depth_m;
    double nearest_px = kNearShare * views_[mark.photo].intrinsics.width_px;
    for (const Seen& one : seen_[mark.photo]) {
      const double apart_px = (one.pixel_in_image - mark.pixel_in_image).norm();
      if (apart_px > nearest_px) continue;
      nearest_px = apart_px;
      depth_m = one.depth_m;
    }
    return depth_m;
  }

  const std::vector<View>& views_;
  std::vector<std::vector<Seen>> seen_;  // by photo; of those with marks
};

void RefuseLists(const std::map<std::string, Remark>& why, const std::vector<ControlPoint>& control,
                 BundleProblem& problem, std::vector<ControlReport>& reports) {
  if (why.empty()) return;
  for (std::size_t k = 0; k < control.size(); ++k) {
    const auto found = why.find(control[k].list);
    if (found != why.end()) reports[k].reason = found->second;
  }
  std::erase_if(problem.control,
                [&](const BundleControl& tied) { return why.contains(control[tied.report].list); });
}

// Lists most of whose marks fit nothing that the photos show.
void RefuseByMarks(const std::vector<ControlPoint>& control, const std::vector<std::size_t>& marks_tied,
                   BundleProblem& problem, std::vector<ControlReport>& reports) {
  struct Tally {
    std::size_t marks = 0, fit = 0;
  };
  std::map<std::string, Tally> tallies;
  for (std::size_t k = 0; k < control.size(); ++k) tallies[control[k].list].marks += marks_tied[k];
  const std::vector<View> views = ViewsOf(problem);
  const GroundSeen ground(problem, views);
  for (const BundleControl& tied : problem.control) {
    if (!ground.IsOff(tied.track)) tallies[control[tied.report].list].fit += tied.track.observations.size();
  }
  std::map<std::string, Remark> why;
  for (const auto& [list, tally] : tallies) {
    if (tally.marks < kFewestJudgedMarks || 2 * tally.fit >= tally.marks) continue;
    why.emplace(list, Remark{RemarkCode::kControlOfOtherPixels,
                             {{"file", list}, {"wrong", tally.marks - tally.fit}, {"marks", tally.marks}}});
  }
  RefuseLists(why, control, problem, reports);
}

// By point of `problem.control`: surveyed minus where the photos show it, once the block is where its
// positions say.
std::vector<Vector2d> ResidualsOfRecords(const BundleProblem& problem, const poses::RecordsApart& own) {
  std::vector<Vector2d> residuals_m;
  for (const BundleControl& tied : problem.control)
    residuals_m.push_back((tied.surveyed_in_enu - tied.track.point_in_enu).head<2>() - own.apart_m);
  return residuals_m;
}

// Two or three points that contradict each other: those that the positions speak against, while at least as
// many agree with them, are the wrong ones.
void RefuseFewByRecords(const poses::RecordsApart& own, BundleProblem& problem,
                        std::vector<ControlReport>& reports) {
  if (problem.control.size() < 2 || problem.control.size() >= kEnoughToVote) return;
  const std::vector<Vector2d> residuals_m = ResidualsOfRecords(problem, own);
  std::vector<Vector2d> agreeing_m;
  for (const Vector2d& residual_m : residuals_m) {
    if (residual_m.norm() <= own.refuting_m) agreeing_m.push_back(residual_m);
  }
  if (2 * agreeing_m.size() < residuals_m.size()) return;
  std::size_t k = 0;
  std::erase_if(problem.control, [&](const BundleControl& tied) {
    const Vector2d& residual_m = residuals_m[k++];
    const bool is_refuted = residual_m.norm() > own.refuting_m &&
                            std::all_of(agreeing_m.begin(), agreeing_m.end(), [&](const Vector2d& other_m) {
                              return (residual_m - other_m).norm() > own.refuting_m;
                            });
    if (is_refuted)
      reports[tied.report].reason = {RemarkCode::kPointFarFromRecords, {{"apart_m", residual_m.norm()}}};
    return is_refuted;
  });
}

void RefuseElsewhere(const poses::RecordsApart& own, const std::vector<ControlPoint>& control,
                     BundleProblem& problem, std::vector<ControlReport>& reports) {
  const std::vector<Vector2d> residuals_m = ResidualsOfRecords(problem, own);
  std::map<std::string, std::vector<Vector2d>> residuals_of_m;
  for (std::size_t k = 0; k < residuals_m.size(); ++k)
    residuals_of_m[control[problem.control[k].report].list].push_back(residuals_m[k]);
  std::map<std::string, Remark> why;
  for (const auto& [list, of_list_m] : residuals_of_m) {
    const double apart_m = MedianByAxis(of_list_m).norm();
    if (apart_m > poses::kFarFromPhotosM)
      why.emplace(list, Remark{RemarkCode::kControlElsewhere, {{"file", list}, {"apart_m", apart_m}}});
  }
  RefuseLists(why, control, problem, reports);
}

}  // namespace

std::optional<poses::RecordsApart> RecordsApartOfBlock(const poses::PosedFlight& posed, const PhotoSet& tied,
                                                       const std::vector<Vector3d>& centers_in_enu) {
  std::vector<poses::RecordedResidual> residuals;
  for (std::size_t i = 0; i < centers_in_enu.size(); ++i) {
    const std::optional<flight::RecordedPosition>& record = posed.photos[i].photo.position;
    if (!record || !tied.Has(i)) continue;
    const Vector3d recorded = posed.frame.EnuAtHeight(record->position, centers_in_enu[i].z());
    residuals.push_back({(recorded - centers_in_enu[i]).head<2>(), &*record});
  }
  return poses::RecordsApartOf(residuals);
}

void RefuseControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                   const std::vector<std::size_t>& marks_tied, const PhotoSet& tied, BundleProblem& problem,
                   std::vector<ControlReport>& reports) {
  RefuseByMarks(control, marks_tied, problem, reports);
  if (problem.control.empty()) return;
  std::vector<Vector3d> centers_in_enu;
  for (const BundlePhoto& photo : problem.photos)
    centers_in_enu.push_back(photo.cam_from_enu.TargetOriginInSource());
  const auto own = RecordsApartOfBlock(posed, tied, centers_in_enu);
  if (!own) return;
  RefuseFewByRecords(*own, problem, reports);
  RefuseElsewhere(*own, control, problem, reports);
}

}  // namespace skyquilt::alignment
