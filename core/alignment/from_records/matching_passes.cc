#include "core/alignment/from_records/matching_passes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/alignment/from_records/ground_graph.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr int kMaxRounds = 4;
constexpr std::size_t kMinConnected = 6;
constexpr double kToleranceShare =
    0.015;  // of a photo's width: by which verified pairs may contradict each other
// Recorded tilts distort the ground by more than that.
constexpr double kFirstToleranceFactor = 2.0;

const MatchingPass kFirstPass{};
// From where the photos are now: narrow for those that are connected, as wide as the records proved bad for
// the others.
const MatchingPass kNextPass{.min_radius_share = 0.05,
                             .sigmas = 3.0,
                             .max_turn_rad = 0.45,
                             .tolerance_share = 0.012,
                             .min_matches = 8};

// What the connected photos of a group, at least one, say of the errors they share.
struct SharedError {
  Complex shift{0.0, 0.0};
  double turn_rad = 0.0;
  double shift_scatter_m = 0.0;
  double turn_scatter_rad = 0.0;
};

SharedError Learn(const std::vector<PhotoGround>& grounds, const std::vector<int>& members) {
  SharedError shared;
  std::vector<double> east, north, turned;
  Complex mean_turn(0.0, 0.0);
  for (const int i : members) {
    east.push_back(grounds[i].correction.shift.real());
    north.push_back(grounds[i].correction.shift.imag());
    mean_turn += std::polar(1.0, std::arg(grounds[i].correction.turn_and_scale));
  }
  shared.shift = {Median(east), Median(north)};
  // Turns are learnt around their mean direction, so that a line stored upside down is one too.
  const double around = std::arg(mean_turn);
  for (const int i : members) {
    turned.push_back(
        std::remainder(std::arg(grounds[i].correction.turn_and_scale) - around, 2.0 * std::numbers::pi));
  }
  const double middle = Median(turned);
  shared.turn_rad = std::remainder(around + middle, 2.0 * std::numbers::pi);
  shared.turn_scatter_rad = 1.5 * MedianOf(turned, [&](double turn) { return std::abs(turn - middle); });
  // Of two dimensions: the median is 1.18 sigma.
  shared.shift_scatter_m =
      1.2 * MedianOf(members, [&](int i) { return std::abs(grounds[i].correction.shift - shared.shift); });
  return shared;
}

// Photos without a verified pair take over what their line has in common.
void Inherit(const std::vector<int>& lines, std::vector<PhotoGround>& grounds) {
  std::map<int, std::vector<int>> connected_of_line;
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    if (grounds[i].component >= 0) connected_of_line[lines[i]].push_back(static_cast<int>(i));
  }
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    if (grounds[i].component >= 0) continue;
    const auto members = connected_of_line.find(lines[i]);
    if (members == connected_of_line.end() || members->second.size() < 2) continue;
    const SharedError of_line = Learn(grounds, members->second);
    grounds[i].correction = {std::polar(1.0, of_line.turn_rad), of_line.shift};
    grounds[i].component = kInheritedComponent;
  }
}

// How good the records are, where the pictures know better than what was assumed of them.
void WidenSigmas(std::vector<PhotoGround>& grounds) {
  std::vector<int> connected;
  for (std::size_t i = 0; i < grounds.size(); ++i) {
    if (grounds[i].component >= 0) connected.push_back(static_cast<int>(i));
  }
  if (connected.size() < kMinConnected) return;
  const SharedError of_flight = Learn(grounds, connected);
  for (PhotoGround& one : grounds) {
    one.sigma_m = std::max(one.sigma_m, of_flight.shift_scatter_m);
    one.sigma_turn_rad = std::max(one.sigma_turn_rad, of_flight.turn_scatter_rad);
  }
}

std::size_t CountPlaced(const std::vector<PhotoGround>& grounds) {
  return std::count_if(grounds.begin(), grounds.end(),
                       [](const PhotoGround& one) { return one.component >= 0; });
}

std::vector<PhotoPair> KeepInliers(const GroundGraph& graph, const std::vector<PhotoPair>& verified) {
  std::vector<PhotoPair> kept;
  for (std::size_t l = 0; l < verified.size(); ++l) {
    if (graph.is_inlier[l]) kept.push_back(verified[l]);
  }
  return kept;
}

void ReportRejected(const GroundGraph& graph, const std::vector<PhotoPair>& verified,
                    const poses::PosedFlight& posed, std::vector<AlignPairReport>& told) {
  for (std::size_t l = 0; l < verified.size(); ++l) {
    if (graph.is_inlier[l]) continue;
    AlignPairReport& rejected = told.emplace_back();
    rejected.first = posed.photos[verified[l].first].photo.name;
    rejected.second = posed.photos[verified[l].second].photo.name;
    rejected.matches = static_cast<int>(verified[l].matches.size());
    rejected.rms_m = verified[l].rms_m;
  }
}

}  // namespace

std::vector<AlignPairReport> MatchInPasses(const poses::PosedFlight& posed, const std::vector<int>& lines,
                                           MatchedFlight& matched, int threads, Progress& progress) {
  const std::size_t count = posed.photos.size();
  const Relief flat(posed.ground_z_in_enu_m);
  const double tolerance_m = kToleranceShare * MedianWidthM(matched.views);
  std::vector<PhotoGround> recorded = MakeGrounds(posed, matched);  // corrected against the records
  std::vector<AlignPairReport> rejected;
  matched.findings.resize(count);
  double mount_turn_rad = 0.0;
  const auto move_views = [&] {
    WidenSigmas(recorded);
    Inherit(lines, recorded);
    for (PhotoGround& one : recorded) {
      if (one.component >= 0 || one.component == kInheritedComponent || mount_turn_rad == 0.0) continue;
      one.correction = {std::polar(1.0, mount_turn_rad), {0.0, 0.0}};
      one.component = kInheritedComponent;
    }
    for (std::size_t i = 0; i < count; ++i) {
      matched.findings[i] = CorrectPose(posed.photos[i], recorded[i]);
      matched.views[i].cam_from_enu = matched.findings[i].start_cam_from_enu;
      const bool is_placed = recorded[i].component >= 0;
      matched.ground_sigma_m[i] = is_placed ? 0.0 : recorded[i].sigma_m;
      matched.sigma_turn_rad[i] = is_placed ? 0.0 : recorded[i].sigma_turn_rad;
    }
  };

  GroundKeypoints projected;
  std::vector<PhotoPair> verified;
  const auto match = [&](const MatchingPass& pass) {
    matched.pairs = SelectPairs(matched.views, matched.ground_sigma_m, flat);
    projected = ProjectAllToGround(matched, flat, threads);
    verified = MatchAndVerify(matched, projected, pass, threads);
  };
  const auto match_first_pass = [&] {
    match(kFirstPass);
    for (PhotoPair& pair : MatchLostPhotos(matched, projected, verified, threads)) {
      verified.push_back(std::move(pair));
    }
  };
  match_first_pass();
  mount_turn_rad = CommonQuarterTurn(recorded, verified);
  if (mount_turn_rad != 0.0) {
    for (std::size_t i = 0; i < count; ++i) {
      recorded[i].correction = {std::polar(1.0, mount_turn_rad), {0.0, 0.0}};
      recorded[i].component = 0;
      matched.views[i].cam_from_enu = CorrectPose(posed.photos[i], recorded[i]).start_cam_from_enu;
    }
    match_first_pass();
  }
  GroundGraph graph = SolveGroundGraph(recorded, verified, projected, kFirstToleranceFactor * tolerance_m);
  ReportRejected(graph, verified, posed, rejected);
  matched.links = KeepInliers(graph, verified);
  recorded = graph.photos;
  for (PhotoGround& one : recorded) {
    if (one.component >= 0) one.correction.turn_and_scale *= std::polar(1.0, mount_turn_rad);
  }
  std::size_t placed = CountPlaced(recorded);
  for (int round = 0; round < kMaxRounds && !progress.IsCancelled(); ++round) {
    move_views();
    match(kNextPass);
    // From here a photo is expected where it now lies.
    std::vector<PhotoGround> expected = MakeGrounds(posed, matched);
    for (std::size_t i = 0; i < count; ++i) {
      expected[i].sigma_m = recorded[i].sigma_m;
      expected[i].sigma_turn_rad = recorded[i].sigma_turn_rad;
    }
    graph = SolveGroundGraph(std::move(expected), verified, projected, tolerance_m);
    matched.links = KeepInliers(graph, verified);
    for (std::size_t i = 0; i < count; ++i) {
      if (graph.photos[i].component < 0 && recorded[i].component >= 0) continue;
      recorded[i].SetMotion(graph.photos[i].Motion().After(recorded[i].Motion()));
      recorded[i].component = graph.photos[i].component;
    }
    const std::size_t now_placed = CountPlaced(recorded);
    if (now_placed <= placed) break;
    placed = now_placed;
  }
  ReportRejected(graph, verified, posed, rejected);
  move_views();
  return rejected;
}

}  // namespace skyquilt::alignment
