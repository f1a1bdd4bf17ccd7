#include "core/poses/time/event_alignment.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace skyquilt::poses {
namespace {

constexpr double kReward = 4.0;  // of a pair, against half its squared normalised error
constexpr std::size_t kCandidates = 12;
constexpr std::size_t kMaxEventsPerStamp = 16;
constexpr double kTriggerJitterS = 0.03;  // a constant interval is constant to this

double NormalCdf(double x) { return 0.5 * std::erfc(-x * M_SQRT1_2); }

// How far a true pair may lie from stamp - event = offset - resolution / 2.
double HalfWindow(const StampModel& model) { return 0.5 * model.resolution_s + 4.0 * model.jitter_s + 0.02; }

// Offsets that many pairs vote for, best first.
std::vector<double> VoteForOffsets(std::span<const double> stamps, std::span<const double> events,
                                   const StampModel& model, std::size_t max_votes) {
  const std::size_t step = std::max<std::size_t>(1, stamps.size() * events.size() / max_votes);
  std::vector<double> votes;
  votes.reserve(stamps.size() / step * events.size() + events.size());
  for (std::size_t i = 0; i < stamps.size(); i += step) {
    for (const double event : events) votes.push_back(stamps[i] - event);
  }
  std::sort(votes.begin(), votes.end());
  const double window = 2.0 * HalfWindow(model);
  struct Peak {
    double middle;
    std::size_t count;
  };
  std::vector<Peak> windows;
  windows.reserve(votes.size());
  for (std::size_t first = 0, last = 0; first < votes.size(); ++first) {
    while (last < votes.size() && votes[last] <= votes[first] + window) ++last;
    windows.push_back({0.5 * (votes[first] + votes[last - 1]), last - first});
  }
  std::stable_sort(windows.begin(), windows.end(),
                   [](const Peak& a, const Peak& b) { return a.count > b.count; });
  std::vector<double> offsets;
  for (const Peak& peak : windows) {
    const bool is_new = std::none_of(offsets.begin(), offsets.end(),
                                     [&](double o) { return std::abs(o - peak.middle) < 0.5 * window; });
    if (is_new) offsets.push_back(peak.middle);
    if (offsets.size() == kCandidates) break;
  }
  return offsets;
}

// Prefix maxima over events, with the node of the pairing that reaches them.
class BestBefore {
 public:
  explicit BestBefore(std::size_t size) : score_(size + 1, 0.0), node_(size + 1, -1) {}
  std::pair<double, int> Before(std::size_t event) const {
    std::pair<double, int> best{0.0, -1};
    for (std::size_t i = event; i > 0; i -= i & (~i + 1)) {
      if (score_[i] > best.first) best = {score_[i], node_[i]};
    }
    return best;
  }
  void Raise(std::size_t event, double score, int node) {
    for (std::size_t i = event + 1; i < score_.size(); i += i & (~i + 1)) {
      if (score > score_[i]) {
        score_[i] = score;
        node_[i] = node;
      }
    }
  }

 private:
  std::vector<double> score_;
  std::vector<int> node_;
};

struct Pairing {
  double score = 0.0;
  std::vector<std::optional<std::size_t>> event;
  std::vector<double> differences;
};

// The best monotone pairing when stamp - event should be `middle`.
Pairing PairMonotonically(std::span<const double> stamps, std::span<const double> events, double middle,
                          double half_unit, double sigma, double half_window) {
  struct Node {
    std::size_t stamp;
    std::size_t event;
    int previous;
  };
  std::vector<Node> nodes;
  BestBefore best(events.size());
  struct Raise {
    std::size_t event;
    double score;
    int node;
  };
  std::vector<Raise> raises;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double at = stamps[i] - middle;
    auto j = static_cast<std::size_t>(std::lower_bound(events.begin(), events.end(), at - half_window) -
                                      events.begin());
    raises.clear();
    for (std::size_t n = 0; n < kMaxEventsPerStamp && j < events.size() && events[j] <= at + half_window;
         ++n, ++j) {
      // Inside the unit that was cut away every place is as likely; of two events the first is the shutter's.
      const double z =
          std::max(0.0, std::abs(events[j] - at) - half_unit) / sigma + 0.05 * static_cast<double>(n);
      const auto [score, previous] = best.Before(j);
      nodes.push_back({i, j, previous});
      raises.push_back({j, score + kReward - 0.5 * z * z, static_cast<int>(nodes.size()) - 1});
    }
    for (const Raise& raise : raises) best.Raise(raise.event, raise.score, raise.node);
  }
  Pairing pairing;
  pairing.event.resize(stamps.size());
  const auto [score, last] = best.Before(events.size());
  pairing.score = score;
  for (int node = last; node >= 0; node = nodes[static_cast<std::size_t>(node)].previous) {
    const Node& pair = nodes[static_cast<std::size_t>(node)];
    pairing.event[pair.stamp] = pair.event;
    pairing.differences.push_back(stamps[pair.stamp] - events[pair.event]);
  }
  return pairing;
}

struct Candidate {
  Pairing pairing;
  double middle = 0.0;  // of stamp - event
};

// Pairs, and pairs again about the median of what was paired.
Candidate Settle(std::span<const double> stamps, std::span<const double> events, double middle,
                 const StampModel& model) {
  Candidate candidate{{}, middle};
  const double sigma = model.jitter_s + 0.01;
  for (int round = 0; round < 3; ++round) {
    candidate.pairing = PairMonotonically(stamps, events, candidate.middle, 0.5 * model.resolution_s, sigma,
                                          HalfWindow(model));
    if (candidate.pairing.differences.empty()) return candidate;
    const auto [least, most] =
        std::minmax_element(candidate.pairing.differences.begin(), candidate.pairing.differences.end());
    // Cut stamps fill their unit: its middle is that of the extremes unless a stray pair stretches them.
    const bool fills = *most - *least <= model.resolution_s + 6.0 * model.jitter_s;
    candidate.middle = fills ? 0.5 * (*least + *most) : Median(candidate.pairing.differences);
  }
  return candidate;
}

}  // namespace

OffsetFit FitOffset(std::span<const double> differences, const StampModel& model) {
  // Posterior on a grid, flat prior: a difference is the offset less a uniform share of a unit, with jitter.
  const double resolution = std::max(model.resolution_s, 1e-3);
  const double jitter = std::max(model.jitter_s, 2e-3);
  const double middle =
      Median(std::vector<double>(differences.begin(), differences.end())) + 0.5 * resolution;
  const double reach = 0.6 * resolution + 5.0 * jitter;
  constexpr int kSteps = 600;
  constexpr double kOutlier = 1e-4;
  std::vector<double> log_likelihood(2 * kSteps + 1, 0.0);
  double most = -1e300;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double offset = middle + reach * k / kSteps;
    double sum = 0.0;
    for (const double difference : differences) {
      const double cut = offset - difference;  // should lie in 0..resolution
      const double inside = NormalCdf(cut / jitter) - NormalCdf((cut - resolution) / jitter);
      sum += std::log(inside / resolution + kOutlier);
    }
    log_likelihood[static_cast<std::size_t>(k + kSteps)] = sum;
    most = std::max(most, sum);
  }
  double weight = 0.0, mean = 0.0, square = 0.0;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double w = std::exp(log_likelihood[static_cast<std::size_t>(k + kSteps)] - most);
    const double x = reach * k / kSteps;
    weight += w;
    mean += w * x;
    square += w * x * x;
  }
  mean /= weight;
  OffsetFit fit;
  fit.offset_s = middle + mean;
  fit.sigma_s = std::sqrt(std::max(square / weight - mean * mean, 0.0) + std::pow(reach / kSteps, 2));
  return fit;
}

std::optional<EventAlignment> AlignEvents(std::span<const double> stamps, std::span<const double> events,
                                          const StampModel& model, std::size_t max_votes) {
  if (stamps.empty() || events.empty()) return std::nullopt;
  std::optional<Candidate> best;
  std::vector<Candidate> all;
  for (const double middle : VoteForOffsets(stamps, events, model, max_votes))
    all.push_back(Settle(stamps, events, middle, model));
  for (const Candidate& candidate : all) {
    if (!best || candidate.pairing.score > best->pairing.score) best = candidate;
  }
  const std::size_t matched = best->pairing.differences.size();
  const std::size_t shorter = std::min(stamps.size(), events.size());
  if (matched < 3 || 2 * matched < shorter) return std::nullopt;
  EventAlignment alignment;
  alignment.event = best->pairing.event;
  alignment.matched = matched;
  // Within one pair's reward the rival cannot be told from the truth.
  for (const Candidate& candidate : all) {
    const double apart = std::abs(candidate.middle - best->middle);
    if (apart <= HalfWindow(model) || candidate.pairing.score <= best->pairing.score - 0.5 * kReward)
      continue;
    if (std::find(alignment.rivals.begin(), alignment.rivals.end(), candidate.pairing.event) ==
        alignment.rivals.end())
      alignment.rivals.push_back(candidate.pairing.event);
    if (alignment.ambiguous_by_s == 0.0 || apart < alignment.ambiguous_by_s) alignment.ambiguous_by_s = apart;
  }
  return alignment;
}

namespace {

// Phase and interval that keep every stamp of a run inside its unit, if any do: the middle of their region.
struct Interval {
  double interval_s = 0.0;
  double first_s = 0.0;
  double slack_s = 0.0;  // the width of what is allowed for the phase
};

std::optional<Interval> FitInterval(std::span<const double> stamps, double resolution) {
  const std::size_t count = stamps.size();
  const double span = stamps.back() - stamps.front();
  const double rough = span / static_cast<double>(count - 1);
  const double reach = resolution / static_cast<double>(count - 1);
  constexpr int kSteps = 200;
  double weight = 0.0, interval = 0.0, phase = 0.0, widest = 0.0;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double t = rough + reach * k / kSteps;
    double low = -1e300, high = 1e300;
    for (std::size_t i = 0; i < count; ++i) {
      const double rest = stamps[i] - stamps.front() - t * static_cast<double>(i);
      low = std::max(low, rest);
      high = std::min(high, rest + resolution);
    }
    const double width = high - low + 2.0 * kTriggerJitterS;
    if (width <= 0.0) continue;
    weight += width;
    interval += width * t;
    phase += width * 0.5 * (low + high);
    widest = std::max(widest, width);
  }
  if (weight <= 0.0) return std::nullopt;
  return Interval{interval / weight, stamps.front() + phase / weight, widest};
}

// How many stamps from `start` on one interval explains, found in growing and then shrinking steps.
std::pair<std::size_t, std::optional<Interval>> LongestRun(std::span<const double> stamps, std::size_t start,
                                                           double resolution, std::size_t shortest) {
  if (start + shortest > stamps.size()) return {0, std::nullopt};
  std::size_t length = shortest;
  auto best = FitInterval(stamps.subspan(start, length), resolution);
  if (!best) return {0, std::nullopt};
  for (std::size_t step = 1; step > 0;) {
    const std::size_t longer = std::min(length + step, stamps.size() - start);
    const auto fit = longer > length ? FitInterval(stamps.subspan(start, longer), resolution) : std::nullopt;
    if (fit) {
      best = fit;
      length = longer;
      step *= 2;
    } else {
      step /= 2;
    }
  }
  return {length, best};
}

}  // namespace

RefinedStamps RefineByTriggerInterval(std::span<const double> stamps, double resolution) {
  constexpr std::size_t kShortestRun = 8;
  RefinedStamps refined;
  for (const double stamp : stamps) {
    refined.times_s.push_back(stamp + 0.5 * resolution);
    refined.sigmas_s.push_back(resolution / std::sqrt(12.0));
  }
  if (resolution < 0.05 || stamps.empty()) return refined;
  double shared = 0.0;       // sum over stamps of the variance that the stamps of their run share
  double independent = 0.0;  // sum over the other stamps
  // The longest of the runs that start here or soon after: a first shot out of step must not bend a run.
  constexpr std::size_t kStartsTried = 6;
  for (std::size_t start = 0; start + kShortestRun <= stamps.size();) {
    std::size_t begin = start;
    std::size_t length = 0;
    std::optional<Interval> best;
    for (std::size_t tried = start; tried < start + kStartsTried; ++tried) {
      const auto [run, interval] = LongestRun(stamps, tried, resolution, kShortestRun);
      if (interval && run > length) {
        begin = tried;
        length = run;
        best = interval;
      }
    }
    if (!best) {
      independent += resolution * resolution / 12.0;
      ++start;
      continue;
    }
    independent += static_cast<double>(begin - start) * resolution * resolution / 12.0;
    start = begin;
    // A shot out of step at either end can pass for a phase: the phase is taken from the inner ones.
    constexpr std::size_t kEnds = 2;
    if (length >= kShortestRun + 2 * kEnds) {
      if (auto inner = FitInterval(stamps.subspan(start + kEnds, length - 2 * kEnds), resolution)) {
        inner->first_s -= static_cast<double>(kEnds) * inner->interval_s;
        best = inner;
      }
    }
    const double slack = std::min(best->slack_s, resolution);
    shared += static_cast<double>(length) * slack * slack / 12.0;
    // A run whose stamps leave the phase free to half a unit taught nothing.
    if (slack < 0.5 * resolution) {
      for (std::size_t i = 0; i < length; ++i) {
        refined.times_s[start + i] = best->first_s + best->interval_s * static_cast<double>(i);
        refined.sigmas_s[start + i] = std::hypot(slack / std::sqrt(12.0), 0.01);
      }
      refined.refined += length;
    }
    start += length;
  }
  const auto count = static_cast<double>(stamps.size());
  refined.common_sigma_s = std::sqrt(shared / count + independent / (count * count));
  return refined;
}

}  // namespace skyquilt::poses
