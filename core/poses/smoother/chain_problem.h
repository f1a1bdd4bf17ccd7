// ChainProblem: the maximum a posteriori problem of one flight: knots (ChainTimeline says where), inertial
// sums and measurements placed in time, and what the course says of the nose (JudgeCourse). Gives the cost of
// a guess and the normal equations about it. Frames and units as in smoother.h. One thread.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/poses/smoother/block_skyline.h"
#include "core/poses/smoother/chain_factors.h"
#include "core/poses/smoother/chain_state.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

// Of a knot, a photo or a measurement, which are counted as int, in a vector.
inline std::size_t Index(int i) { return static_cast<std::size_t>(i); }
// Of a direction in enu, clockwise from north.
inline double HeadingOf(const Eigen::Vector3d& v) { return std::atan2(v.x(), v.y()); }

struct TimePlace {
  int knot = 0;         // the knot at or before the time
  double weight = 0.0;  // 0 at that knot, towards 1 at the next; 0 exactly when the time is the knot's own
};

// Where the knots lie and between which two a measurement falls.
class ChainTimeline {
 public:
  // Knots at begin_s, at each of `fixed_times` (rising, at or after begin_s), at end_s, and evenly between
  // them, no further apart than spacing_s. Times closer than a tenth of a millisecond share a knot.
  ChainTimeline(double begin_s, double end_s, const std::vector<double>& fixed_times, double spacing_s);

  const std::vector<double>& times() const { return times_; }
  int size() const { return static_cast<int>(times_.size()); }
  double Duration(int interval) const;
  // Nothing outside the chain.
  std::optional<TimePlace> Place(double t_s) const;
  // The knot nearest to a time.
  int Nearest(double t_s) const;

 private:
  std::vector<double> times_;
};

inline constexpr double kCourseMinSpeedMps = 3.0;  // of knots whose course is believed

// JudgeCourse: what a flight's course says of its recorded headings. A nose that keeps to the course shows
// where the compass errs; how well it keeps to it is measured on the flight itself, by how far recorded
// headings and courses lie apart where the flight runs straight. Flights sideways, and small aircraft that
// crab in the wind, give no evidence.
struct CourseEvidence {
  double sigma_rad = 0.0;           // of the nose against the course, a slow error
  std::vector<bool> runs_straight;  // one per knot: fast enough and turning neither way nor nose
};

// knots: headings as recorded. Nothing where fewer than 10 knots run straight or the nose leaves it.
std::optional<CourseEvidence> JudgeCourse(const std::vector<KnotState>& knots,
                                          const std::vector<double>& times_s);

struct ChainGuess {
  std::vector<KnotState> knots;
  BorderState border;
};

class ChainProblem {
 public:
  // `input` is clean (finite, in order, inside the timeline) and outlives the problem.
  ChainProblem(const SmootherInput& input, ChainTimeline timeline);

  const SmootherInput& input() const { return input_; }
  const ChainTimeline& timeline() const { return timeline_; }
  bool HasBorder() const { return has_border_; }
  const Vector22& border_sigma() const { return border_sigma_; }
  bool HasImu(int interval) const { return imu_[Index(interval)].has_value(); }
  int ImuIntervals() const;
  const Preintegration& Imu(int interval) const { return *imu_[Index(interval)]; }
  int PhotoKnot(int photo) const { return photo_knots_[Index(photo)]; }
  bool IsStill(int knot) const { return still_[Index(knot)]; }

  // Takes a guess as the point about which the inertial samples are summed (its biases), from which the weak
  // prior of the first rotation is taken, and whose speeds say where a course has a meaning.
  void ExpandAbout(const std::vector<KnotState>& knots);
  // The outline of the system: neighbours, photo links, for covariances each photo to the one before.
  std::vector<int> Outline(bool with_photo_neighbours) const;

  // `report`: counts the factors where it is given.
  double Cost(const ChainGuess& guess, SmootherReport* report = nullptr) const;
  // Fills matrix and gradient (of the cost, by each block's small step); returns the cost.
  double Linearise(const ChainGuess& guess, BlockSkyline& matrix, std::vector<Vector22>& gradient) const;

  // The state a fix sees; `fix` is its number in the series' order of placement.
  struct Placed {
    TimePlace place;
    int cut = -1;  // which inertial sum of the interval reaches its time
    int fix = 0;
    double t_s = 0.0;
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

// The first guess, from the best that the inputs offer: recorded attitudes; GNSS tracks; without GNSS the
// chain of photo-to-photo motions scaled by the height; and only last dead reckoning, which starts
// Gauss-Newton kilometres off. Leaves `problem` expanded about the guess.
ChainGuess GuessChain(ChainProblem& problem);

}  // namespace skyquilt::poses
