// ChainProblem: the maximum a posteriori problem of one flight: knots, inertial sums and measurements placed
// in time. Gives the cost of a guess and the normal equations about it. Frames and units as in smoother.h.
// One thread.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/poses/smoother/block_skyline.h"
#include "core/poses/smoother/chain_factors.h"
#include "core/poses/smoother/chain_timeline.h"
#include "core/poses/smoother/course_evidence.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

struct ChainGuess {
  std::vector<KnotState> knots;
  BorderState border;
  std::string start;  // how it was made, in words
};

// What a pass over all factors counts beside the cost.
struct FactorCount {
  std::map<std::string, int> used;
  std::map<std::string, int> down_weighted;
  int residuals = 0;
};

class ChainProblem {
 public:
  // `input` is clean (finite, in order, inside the timeline) and outlives the problem.
  ChainProblem(const SmootherInput& input, ChainTimeline timeline);

  const SmootherInput& input() const { return input_; }
  const ChainTimeline& timeline() const { return timeline_; }
  bool HasBorder() const { return has_border_; }
  const Vector22& border_sigma() const { return border_sigma_; }
  bool HasImu(int interval) const { return imu_[static_cast<std::size_t>(interval)].has_value(); }
  int ImuIntervals() const;
  const Preintegration& Imu(int interval) const { return *imu_[static_cast<std::size_t>(interval)]; }
  int PhotoKnot(int photo) const { return photo_knots_[static_cast<std::size_t>(photo)]; }
  bool IsStill(int knot) const { return still_[static_cast<std::size_t>(knot)]; }

  // Takes a guess as the point about which the inertial samples are summed (its biases), from which the weak
  // prior of the first rotation is taken, and whose speeds say where a course has a meaning.
  void ExpandAbout(const std::vector<KnotState>& knots);
  // The outline of the system: neighbours, photo links, and, for covariances, each photo back to the one
  // before.
  std::vector<int> Outline(bool with_photo_neighbours) const;

  double Cost(const ChainGuess& guess, FactorCount* count = nullptr) const;
  // Fills matrix and gradient (of the cost, by each block's small step); returns the cost.
  double Linearise(const ChainGuess& guess, BlockSkyline& matrix, std::vector<Vector22>& gradient) const;

  // The state a fix sees; `fix` is its number in the series' order of placement.
  struct Placed {
    TimePlace place;
    int cut = -1;  // which inertial sum of the interval reaches its time
    int fix = 0;
  };

 private:
  template <typename Sink>
  void Visit(const ChainGuess& guess, Sink& sink) const;
  template <typename Sink>
  void VisitMotion(const ChainGuess& guess, Sink& sink) const;
  template <typename Sink>
  void VisitPriors(const ChainGuess& guess, Sink& sink) const;
  template <typename Sink>
  void VisitFixes(const ChainGuess& guess, Sink& sink) const;
  template <typename Fix>
  std::vector<Placed> PlaceAll(const std::vector<Fix>& fixes);
  StateBetween At(const std::vector<KnotState>& knots, const Placed& placed) const;

  const SmootherInput& input_;
  ChainTimeline timeline_;
  bool has_border_ = false;
  std::vector<std::optional<Preintegration>> imu_;
  std::vector<Matrix9d> imu_whiten_;
  std::vector<std::vector<double>> cuts_;  // times inside each interval that need their own inertial sum
  std::vector<bool> still_;
  std::vector<bool> has_course_;
  std::optional<CourseEvidence> course_evidence_;  // where recorded headings are the only ones
  std::vector<double> turned_rad_;                 // one an interval: how far the heading turns in it
  std::optional<Eigen::Quaterniond> first_rotation_;
  Vector22 border_sigma_ = Vector22::Zero();
  std::vector<int> photo_knots_;
  std::vector<Placed> positions_, velocities_, attitudes_, heights_, ranges_, markers_;
};

}  // namespace skyquilt::poses
