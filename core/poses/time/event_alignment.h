// Which camera event of a log belongs to which photo, by the pattern of their times alone: both lists are in
// order, their clocks differ by one unknown offset, some events are lost, some doubled, and stamps of photos
// are cut to whole units. Candidate offsets come from voting, each is scored by a dynamic programme over
// monotone pairings, and the offset is then estimated from the cut stamps (a uniform error convolved with
// trigger jitter). Pure functions; any thread; deterministic.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace skyquilt::poses {

struct StampModel {
  double resolution_s = 1.0;  // stamps are cut (not rounded) to multiples of this
  double jitter_s = 0.02;     // 1 sigma between the event and the exposure

  // How far differences between stamps and their events lie apart at most.
  double Spread() const { return resolution_s + 8.0 * jitter_s + 0.05; }
};

// The offset of `x = stamp - time` with its sigma: stamp = floor(time + offset + jitter).
struct OffsetFit {
  double offset_s = 0.0;
  double sigma_s = 0.0;
};
OffsetFit FitOffset(std::span<const double> stamp_minus_time_s, const StampModel& model);

using EventOfStamp = std::vector<std::optional<std::size_t>>;

struct EventAlignment {
  EventOfStamp event;
  std::size_t matched = 0;
  // Another offset explains the events almost as well: the distance to it; 0 where the pattern is unique.
  double ambiguous_by_s = 0.0;
  std::vector<EventOfStamp> rivals;  // the pairings by such offsets
};

inline constexpr std::size_t kMaxVotes = 4'000'000;

// Both lists in rising order. Nothing when fewer than three and half of the shorter list can be paired.
// `max_votes`: pairs of a stamp and an event whose offset is looked at.
std::optional<EventAlignment> AlignEvents(std::span<const double> stamps_s, std::span<const double> events_s,
                                          const StampModel& model, std::size_t max_votes = kMaxVotes);

// Stamps of a camera that fires at a constant interval are exact to a few hundredths of a second once the
// interval is fitted: gives the middle of what all cut stamps of each unbroken run allow.
struct RefinedStamps {
  std::vector<double>
      times_s;  // on the camera's clock; half a unit after the stamp where no interval was found
  std::vector<double> sigmas_s;
  std::size_t refined = 0;  // how many stamps belong to a run
  // The part of the error that all stamps share: an interval of whole seconds leaves the fraction open.
  double common_sigma_s = 0.0;
};
RefinedStamps RefineByTriggerInterval(std::span<const double> stamps_s, double resolution_s);

}  // namespace skyquilt::poses
