#include "core/alignment/from_records/ground_graph.h"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>

#include "core/alignment/matching/verified_pair.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr double kAgreesWithYawRad = 0.35;
// Residual of a pair, in tolerances, above which it counts for little: all pairs speak first, then those that
// agree.
constexpr double kTrustWidths[] = {40.0, 20.0, 10.0, 6.0, 4.0, 3.0, 2.0, 1.5, 1.5, 1.5};
constexpr int kMaxPlacesPerPair = 24;
// Of a photo's ground against its record: pairs allow each other less, and a photo that many false ones tie
// shrinks to nothing in their middle. Valleys and wrong heights stretch by less.
constexpr double kBelievedStretch = 3.0;

double Cauchy(double residual, double scale) { return 1.0 / (1.0 + (residual / scale) * (residual / scale)); }

// What the pairs of a flight say, beside what is believed of its photos.
struct PairGraph {
  const std::vector<PhotoGround>& believed;
  const std::vector<PhotoPair>& pairs;
  std::vector<std::vector<int>> of_photo;                        // pairs
  std::vector<std::vector<std::pair<Complex, Complex>>> places;  // by pair; a few matches stand for all
  std::vector<double> tolerances_m;                              // by pair

  // How far apart a pair's two photos put the same places, rms.
  double Residual(std::size_t l, const std::vector<PhotoGround>& photos) const {
    const GroundSimilarity a = photos[pairs[l].first].Motion();
    const GroundSimilarity b = photos[pairs[l].second].Motion();
    double square = 0.0;
    for (const auto& [x, y] : places[l]) square += std::norm(a * x - b * y);
    return std::sqrt(square / static_cast<double>(places[l].size()));
  }
};

// Places the photos of a component relative to each other along the strongest pairs, from the given roots
// outwards, which stay as recorded. Photos of other components get no correction.
std::vector<PhotoGround> SpreadAlongPairs(const std::vector<int>& roots, const PairGraph& graph) {
  std::vector<PhotoGround> photos = graph.believed;
  const auto matches = [](const PhotoPair& pair) { return pair.matches.size(); };
  FollowStrongest(graph.pairs, graph.of_photo, roots, matches, [&](const PhotoPair& pair, int from, int to) {
    // The corrected grounds agree: C_to * (to_from * z) = C_from * z.
    const GroundSimilarity to_from =
        from == pair.first ? pair.second_from_first : pair.second_from_first.Inverse();
    photos[to].SetMotion(photos[from].Motion().After(to_from.Inverse()));
  });
  return photos;
}

// The similarity that brings most of a component's middles to where they were recorded.
GroundSimilarity FitToPositions(const std::vector<int>& members, const std::vector<PhotoGround>& photos) {
  std::vector<Complex> now, recorded;
  for (const int i : members) {
    now.push_back(photos[i].middle + photos[i].correction.shift);
    recorded.push_back(photos[i].middle);
  }
  const auto cost = [&](const GroundSimilarity& motion) {
    double sum = 0.0;
    for (std::size_t k = 0; k < now.size(); ++k) {
      const double residual = std::abs(motion * now[k] - recorded[k]) / (2.0 * photos[members[k]].sigma_m);
      sum += std::min(1.0, residual * residual);
    }
    return sum;
  };
  // No motion is the favourite: another one must explain the positions clearly better.
  GroundSimilarity best;
  double least = cost(best) - 1e-3;
  const std::size_t count = now.size();
  const std::size_t step = std::max<std::size_t>(1, count / 40);
  for (std::size_t a = 0; a < count; a += step) {
    for (std::size_t b = 0; b < count; b += step) {
      if (a == b || std::abs(now[a] - now[b]) < 1e-6 || std::abs(recorded[a] - recorded[b]) < 1e-6) continue;
      const Complex turn = (recorded[b] - recorded[a]) / (now[b] - now[a]);
      if (std::abs(turn) > 1.5 || std::abs(turn) < 1.0 / 1.5) continue;
      const GroundSimilarity motion{turn, recorded[a] - turn * now[a]};
      const double sum = cost(motion) + 0.5;
      if (sum < least) {
        least = sum;
        best = motion;
      }
    }
  }
  return best;
}

// What a component's corrections leave unexplained: residuals of pairs, photos far from where they were
// recorded.
double Unexplained(const std::vector<int>& members, const PairGraph& graph,
                   const std::vector<PhotoGround>& photos) {
  constexpr double kWideTolerances = 4.0;
  double sum = 0.0;
  for (const int i : members) {
    const double away = std::abs(photos[i].correction.shift) / (2.0 * photos[i].sigma_m);
    sum += std::min(1.0, away * away);
    for (const int l : graph.of_photo[i]) {
      if (graph.pairs[l].first != i) continue;
      const double residual = graph.Residual(l, photos) / (kWideTolerances * graph.tolerances_m[l]);
      sum += std::min(1.0, residual * residual);
    }
  }
  return sum;
}

// The corrections of a component as its pairs place it, brought as a whole to the recorded positions.
std::vector<PhotoGround> PlaceComponentOnPositions(const std::vector<int>& members, const PairGraph& graph) {
  std::vector<PhotoGround> photos = SpreadAlongPairs({members.front()}, graph);
  const GroundSimilarity motion = FitToPositions(members, photos);
  for (const int i : members) photos[i].SetMotion(motion.After(photos[i].Motion()));
  return photos;
}

// Whether most of a component's photos come out turned.
bool IsTurnedAsAWhole(const std::vector<int>& members, const std::vector<PhotoGround>& photos) {
  const auto turned = std::count_if(members.begin(), members.end(), [&](int i) {
    return std::abs(std::arg(photos[i].correction.turn_and_scale)) > kAgreesWithYawRad;
  });
  return 2 * turned > std::ssize(members);
}

// One least-squares step over all photos of all components, weighted by what the corrections so far leave;
// unknowns (turn_and_scale, shift) a photo.
void SolveLinear(const PairGraph& graph, double tolerance_m, double trust_width,
                 std::vector<PhotoGround>& photos) {
  const int count = static_cast<int>(photos.size());
  // Blocks of 2x2 by photos; a photo without pairs keeps its prior.
  std::vector<Eigen::Triplet<Complex>> entries;
  Eigen::VectorXcd right = Eigen::VectorXcd::Zero(2 * count);
  const auto add = [&](int row, int column, Complex value) { entries.emplace_back(row, column, value); };
  for (int i = 0; i < count; ++i) {
    const GroundSimilarity& now = photos[i].correction;
    const double sigma = photos[i].sigma_m;
    // Scale stays near one; the turn is free to go where the pairs want it, once it is far from the
    // recorded.
    const Complex unit = std::abs(now.turn_and_scale) > 1e-6
                             ? now.turn_and_scale / std::abs(now.turn_and_scale)
                             : Complex(1.0, 0.0);
    const bool turned = std::abs(std::arg(unit)) > std::max(0.35, 3.0 * photos[i].sigma_turn_rad);
    // A turn moves things about as far out as this.
    const double reach_m = 10.0 * tolerance_m * photos[i].coarseness;
    const double turn_weight = (reach_m * reach_m) / (sigma * sigma);
    add(2 * i, 2 * i, turn_weight);
    right[2 * i] += turn_weight * (turned ? unit : Complex(1.0, 0.0));
    add(2 * i + 1, 2 * i + 1, Cauchy(std::abs(now.shift), 3.0 * sigma) / (sigma * sigma));
  }
  for (std::size_t l = 0; l < graph.pairs.size(); ++l) {
    const int i = graph.pairs[l].first;
    const int j = graph.pairs[l].second;
    const double tolerance = graph.tolerances_m[l];
    const double strength = std::min<double>(4.0, static_cast<double>(graph.pairs[l].matches.size()) / 20.0);
    const double pair_weight =
        strength / (tolerance * tolerance) * Cauchy(graph.Residual(l, photos), tolerance * trust_width);
    const double weight = pair_weight / static_cast<double>(graph.places[l].size());
    Eigen::Matrix4cd block = Eigen::Matrix4cd::Zero();
    Eigen::Vector4cd target = Eigen::Vector4cd::Zero();
    for (const auto& [a, b] : graph.places[l]) {
      const Complex u = a - photos[i].middle;
      const Complex v = b - photos[j].middle;
      Eigen::RowVector4cd row;  // a_i u + t_i - a_j v - t_j = middle_j - middle_i
      row << u, 1.0, -v, -1.0;
      block += row.adjoint() * row;
      target += row.adjoint() * (photos[j].middle - photos[i].middle);
    }
    const int at[4] = {2 * i, 2 * i + 1, 2 * j, 2 * j + 1};
    for (int r = 0; r < 4; ++r) {
      right[at[r]] += weight * target[r];
      for (int c = 0; c < 4; ++c) add(at[r], at[c], weight * block(r, c));
    }
  }
  Eigen::SparseMatrix<Complex> matrix(2 * count, 2 * count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> solver(matrix);
  if (solver.info() != Eigen::Success) return;
  const Eigen::VectorXcd solution = solver.solve(right);
  if (!solution.allFinite()) return;
  for (int i = 0; i < count; ++i) photos[i].correction = {solution[2 * i], solution[2 * i + 1]};
}

}  // namespace

GroundSimilarity PhotoGround::Motion() const {
  return {correction.turn_and_scale, middle + correction.shift - correction.turn_and_scale * middle};
}

void PhotoGround::SetMotion(const GroundSimilarity& motion) {
  correction = {motion.turn_and_scale, motion * middle - middle};
}

GroundGraph SolveGroundGraph(std::vector<PhotoGround> believed, const std::vector<PhotoPair>& pairs,
                             const GroundKeypoints& projected, double tolerance_m) {
  const std::size_t count = believed.size();
  for (PhotoGround& one : believed) one.correction = {}, one.component = -1;
  GroundGraph solution{believed, std::vector<bool>(pairs.size(), true)};
  const ConnectedComponents components = FindConnectedComponents(count, pairs);
  std::vector<int> agreeing(count, 0);
  PairGraph graph{believed, pairs, std::vector<std::vector<int>>(count), {}, {}};
  for (std::size_t l = 0; l < pairs.size(); ++l) {
    const PhotoPair& pair = pairs[l];
    for (const int photo : {pair.first, pair.second}) graph.of_photo[photo].push_back(static_cast<int>(l));
    graph.tolerances_m.push_back(tolerance_m *
                                 std::max(believed[pair.first].coarseness, believed[pair.second].coarseness));
    const Complex moved = pair.second_from_first * believed[pair.first].middle - believed[pair.first].middle;
    const double believable = 3.5 * std::hypot(believed[pair.first].sigma_m, believed[pair.second].sigma_m);
    if (std::abs(std::arg(pair.second_from_first.turn_and_scale)) < kAgreesWithYawRad &&
        std::abs(moved) < believable) {
      ++agreeing[pair.first];
      ++agreeing[pair.second];
    }
    auto& places = graph.places.emplace_back();
    const std::size_t step = std::max<std::size_t>(1, pair.matches.size() / kMaxPlacesPerPair);
    for (std::size_t k = 0; k < pair.matches.size(); k += step) {
      places.emplace_back(projected[pair.first][pair.matches[k].first].place,
                          projected[pair.second][pair.matches[k].second].place);
    }
  }
  for (std::size_t p = 0; p < components.members.size(); ++p) {
    const std::vector<int>& members = components.members[p];
    std::vector<int> roots;
    for (const int i : members) {
      if (agreeing[i] > 0) roots.push_back(i);
    }
    std::vector<PhotoGround> solved = PlaceComponentOnPositions(members, graph);
    if (!roots.empty()) {
      // Between photos that stand close, pairs agree with the record even where all cameras are turned alike:
      // only the whole component shows that.
      std::vector<PhotoGround> as_recorded = SpreadAlongPairs(roots, graph);
      if (!IsTurnedAsAWhole(members, solved) ||
          Unexplained(members, graph, solved) > 0.5 * Unexplained(members, graph, as_recorded)) {
        solved = std::move(as_recorded);
      }
    }
    for (const int i : members) {
      solution.photos[i] = solved[i];
      solution.photos[i].component = static_cast<int>(p);
    }
  }
  for (const double trust_width : kTrustWidths) SolveLinear(graph, tolerance_m, trust_width, solution.photos);
  for (std::size_t l = 0; l < pairs.size(); ++l) {
    if (graph.Residual(l, solution.photos) > 4.0 * graph.tolerances_m[l]) solution.is_inlier[l] = false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double stretch = std::abs(solution.photos[i].correction.turn_and_scale);
    if (stretch <= kBelievedStretch && stretch >= 1.0 / kBelievedStretch) continue;
    solution.photos[i] = believed[i];
    for (const int l : graph.of_photo[i]) solution.is_inlier[l] = false;
  }
  return solution;
}

}  // namespace skyquilt::alignment
