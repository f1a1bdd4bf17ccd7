// ChainTimeline: where the knots of the smoother lie and between which two a measurement falls. Seconds. A
// value once made; any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace skyquilt::poses {

// Of a knot, a photo or a measurement, which are counted as int, in a vector.
inline std::size_t Index(int i) { return static_cast<std::size_t>(i); }

struct TimePlace {
  int knot = 0;         // the knot at or before the time
  double weight = 0.0;  // 0 at that knot, towards 1 at the next; 0 exactly when the time is the knot's own
};

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

}  // namespace skyquilt::poses
