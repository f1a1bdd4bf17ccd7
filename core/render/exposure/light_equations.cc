#include "core/render/exposure/light_equations.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "core/geo/solvers/dense_solvers.h"
#include "core/geo/solvers/sparse_cholesky.h"

namespace skyquilt::render {
namespace {

constexpr int kRounds = 5;
// A misfit beyond this (in log value: 12 %) is another thing moving, glint or relief, not exposure.
constexpr double kRobustScale = 0.12;
// How much a photo's gain may stray without evidence: hardly held, by kGainStepSigma alone.
constexpr double kGainSigma = 2.0;
// By how much the gain changes from one photo of a camera to its next. More than kGainStep in a go is a
// cloud, and counts by its size alone, as often as it comes: were its square to count, half a flight in the
// shade would be evened out by a slope of light over the whole map, which many small changes stand for as
// well.
constexpr double kGainStepSigma = 0.1, kGainStep = 0.02;
// How much a term may. A sample counts little: the misfits of one pair of photos go together, and many such
// pairs in a row would add up to a drift.
constexpr double kTermSigma = 0.25;
// How much of a recorded exposure photos show without evidence: a camera may have followed the light.
constexpr double kExposureSigma = 1.0;
constexpr double kSampleSigma = 0.35;
// What lens and light do somewhere in a photo, without evidence: keeps corners that few samples show from
// following a high power. Asked at so many places a side.
constexpr double kShadeSigma = 0.2;
constexpr int kPriorSteps = 7;

double WeightOf(double sigma) { return (kSampleSigma / sigma) * (kSampleSigma / sigma); }

constexpr std::size_t kOwnTerms = LightTerms::kOfFlight + kCameraTerms;

// What the terms are multiplied with for one sample: of direction, of exposure, then of its photo's camera.
std::array<double, kOwnTerms> OwnBasis(const ExposureSample& sample, const LightTerms& terms) {
  std::array<double, kOwnTerms> own{};
  const auto direction =
      terms.directions.Basis(Eigen::Vector2f(sample.look[0], sample.look[1]).cast<double>());
  std::copy(direction.begin(), direction.end(), own.begin());
  own[LightTerms::kExposure] = terms.exposure_of_photo[sample.photo];
  if (terms.camera_of_photo[sample.photo] == LightTerms::kNone) return own;
  const auto camera = CameraBasis(Eigen::Vector2f(sample.place[0], sample.place[1]).cast<double>());
  std::copy(camera.begin(), camera.end(), own.begin() + LightTerms::kOfFlight);
  return own;
}

// Which of the flight's terms a sample has.
class OwnTerms {
 public:
  OwnTerms(const LightTerms& terms, std::uint32_t photo)
      : count_(terms.camera_of_photo[photo] == LightTerms::kNone ? LightTerms::kOfFlight : kOwnTerms),
        camera_(count_ == kOwnTerms ? LightTerms::OfCamera(terms.camera_of_photo[photo]) : 0) {}
  std::size_t count() const { return count_; }
  Eigen::Index operator[](std::size_t i) const {
    return static_cast<Eigen::Index>(i < LightTerms::kOfFlight ? i : camera_ + i - LightTerms::kOfFlight);
  }

 private:
  std::size_t count_, camera_;
};

// A spot that a thousand photos show is a million gains by gains: so many are summed up at a time.
constexpr std::size_t kMaxGains = std::size_t{1} << 22;

struct Normal {
  std::vector<Eigen::Triplet<double>> gains;  // those that are not in `summed`
  Eigen::SparseMatrix<double> summed;
  Eigen::MatrixXd mixed, terms;  // gains by terms, terms by terms
  Eigen::VectorXd gains_right, terms_right;

  Normal(std::size_t photos, std::size_t term_count)
      : mixed(
            Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(photos), static_cast<Eigen::Index>(term_count))),
        terms(Eigen::MatrixXd::Zero(mixed.cols(), mixed.cols())),
        gains_right(Eigen::VectorXd::Zero(mixed.rows())),
        terms_right(Eigen::VectorXd::Zero(mixed.cols())) {}

  Eigen::SparseMatrix<double> Gains() const {
    Eigen::SparseMatrix<double> all(mixed.rows(), mixed.rows());
    all.setFromTriplets(gains.begin(), gains.end());
    if (summed.nonZeros() > 0) all += summed;
    return all;
  }
  void SumUpMany() {
    if (gains.size() < kMaxGains) return;
    summed = Gains();
    gains.clear();
  }
};

Eigen::Vector2d PriorPlace(int point) {  // -1 to 1
  const int row = point / kPriorSteps, column = point % kPriorSteps;
  return {2.0 * column / (kPriorSteps - 1) - 1.0, 2.0 * row / (kPriorSteps - 1) - 1.0};
}

// What light does at places all over the widest look, a row each, without what grows evenly with the look:
// that is a slope of the ground or of the gains just as well (brightness by place less brightness by camera),
// and to take it out of a hot spot would tilt the map. That gains change little from photo to photo decides.
Eigen::MatrixXd DirectionsAllOver(const Directions& directions) {
  Eigen::MatrixXd all(kPriorSteps * kPriorSteps, static_cast<Eigen::Index>(kDirectionTerms));
  for (int point = 0; point < kPriorSteps * kPriorSteps; ++point) {
    const auto direction = directions.Basis(PriorPlace(point) * directions.widest_look);
    all.row(point) = Eigen::Map<const Eigen::RowVectorXd>(direction.data(), kDirectionTerms);
  }
  // The first two terms, which are orthogonal: the places are the same to all sides.
  const Eigen::MatrixX2d slopes = all.leftCols<2>();
  for (Eigen::Index k = 0; k < 2; ++k) {
    const Eigen::RowVectorXd shares = slopes.col(k).transpose() * all / slopes.col(k).squaredNorm();
    all -= slopes.col(k) * shares;
  }
  return all;
}

// `log_gains`: as the round before found them.
void AddPriors(const LightTerms& terms, const Eigen::VectorXd& log_gains, Normal& normal) {
  for (Eigen::Index photo = 0; photo < normal.mixed.rows(); ++photo)
    normal.gains.emplace_back(photo, photo, WeightOf(kGainSigma));
  std::map<std::size_t, Eigen::Index> last_of_camera;
  for (Eigen::Index photo = 0; photo < normal.mixed.rows(); ++photo) {
    const auto [last, is_first] =
        last_of_camera.try_emplace(terms.camera_of_photo[static_cast<std::size_t>(photo)], photo);
    if (is_first) continue;
    const double step = std::abs(log_gains[photo] - log_gains[last->second]);
    const double weight = WeightOf(kGainStepSigma) * kGainStep / std::max(kGainStep, step);
    normal.gains.emplace_back(photo, photo, weight);
    normal.gains.emplace_back(last->second, last->second, weight);
    normal.gains.emplace_back(photo, last->second, -weight);
    normal.gains.emplace_back(last->second, photo, -weight);
    last->second = photo;
  }
  normal.terms.diagonal().array() += WeightOf(kTermSigma);
  constexpr auto kExposure = static_cast<Eigen::Index>(LightTerms::kExposure);
  normal.terms(kExposure, kExposure) += WeightOf(kExposureSigma) - WeightOf(kTermSigma);
  const Eigen::MatrixXd directions = DirectionsAllOver(terms.directions);
  normal.terms.topLeftCorner<kDirectionTerms, kDirectionTerms>() +=
      WeightOf(kShadeSigma) * directions.transpose() * directions;
  for (int point = 0; point < kPriorSteps * kPriorSteps; ++point) {
    const auto camera = CameraBasis(PriorPlace(point) * std::numbers::sqrt2 / 2.0);
    const Eigen::Map<const Eigen::VectorXd> of_camera(camera.data(), kCameraTerms);
    for (std::size_t k = 0; k < terms.cameras.size(); ++k) {
      const auto first = static_cast<Eigen::Index>(LightTerms::OfCamera(k));
      normal.terms.block<kCameraTerms, kCameraTerms>(first, first) +=
          WeightOf(kShadeSigma) * of_camera * of_camera.transpose();
    }
  }
}

// The samples of one spot: w a a^T of each, less the part along the spot's mean. log v = spot - gain + terms.
class SpotAdder {
 public:
  SpotAdder(const LightTerms& terms, std::size_t channel, Normal& normal)
      : terms_(terms),
        channel_(channel),
        normal_(normal),
        mean_(Eigen::VectorXd::Zero(normal.terms.cols())) {}

  void Add(const ExposureSample* begin, const ExposureSample* end, const double* weights) {
    double weight_sum = 0.0, value_mean = 0.0;
    for (const ExposureSample* sample = begin; sample != end; ++sample) {
      weight_sum += weights[sample - begin];
      value_mean += weights[sample - begin] * static_cast<double>(sample->log_value[channel_]);
    }
    if (weight_sum <= 1e-9) return;
    value_mean /= weight_sum;
    touched_.clear();
    for (const ExposureSample* sample = begin; sample != end; ++sample) {
      const double weight = weights[sample - begin];
      const double value = static_cast<double>(sample->log_value[channel_]) - value_mean;
      const auto own = OwnBasis(*sample, terms_);
      const OwnTerms at(terms_, sample->photo);
      const auto photo = static_cast<Eigen::Index>(sample->photo);
      normal_.gains.emplace_back(photo, photo, weight);
      normal_.gains_right[photo] -= weight * value;
      for (std::size_t i = 0; i < at.count(); ++i) {
        const Eigen::Index row = at[i];
        normal_.mixed(photo, row) -= weight * own[i];
        normal_.terms_right[row] += weight * value * own[i];
        for (std::size_t j = 0; j <= i; ++j) normal_.terms(row, at[j]) += weight * own[i] * own[j];
        if (mean_[row] == 0.0) touched_.push_back(row);
        mean_[row] += weight * own[i];
      }
    }
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const ExposureSample* one = begin; one != end; ++one) {
      const double share = weights[one - begin] / weight_sum;
      const auto photo = static_cast<Eigen::Index>(one->photo);
      for (const ExposureSample* other = begin; other != end; ++other)
        normal_.gains.emplace_back(photo, static_cast<Eigen::Index>(other->photo),
                                   -share * weights[other - begin]);
      normal_.SumUpMany();
      for (const Eigen::Index term : touched_) normal_.mixed(photo, term) += share * mean_[term];
    }
    for (const Eigen::Index row : touched_) {
      for (const Eigen::Index column : touched_) {
        if (column > row) break;
        normal_.terms(row, column) -= mean_[row] * mean_[column] / weight_sum;
      }
    }
    for (const Eigen::Index term : touched_) mean_[term] = 0.0;
  }

 private:
  const LightTerms& terms_;
  const std::size_t channel_;
  Normal& normal_;
  Eigen::VectorXd mean_;
  std::vector<Eigen::Index> touched_;
};

// Of an even number the mean of both in the middle: with either of them all misfits would lean to one side.
double MedianOfMisfits(std::vector<double> misfits) {
  const auto middle = misfits.begin() + static_cast<std::ptrdiff_t>(misfits.size() / 2);
  std::nth_element(misfits.begin(), middle, misfits.end());
  if (misfits.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(misfits.begin(), middle));
}

// False where there is no solution.
bool Solve(const Normal& normal, bool has_spot, SolvedLight& light) {
  const geo::SparseCholesky of_gains(normal.Gains());
  if (!of_gains.is_factored()) return false;
  const Eigen::MatrixXd eliminated = of_gains.Solve(normal.mixed);
  Eigen::MatrixXd left = normal.terms.selfadjointView<Eigen::Lower>();
  left -= normal.mixed.transpose() * eliminated;
  const Eigen::VectorXd terms =
      geo::SolveSymmetric(left, normal.terms_right - eliminated.transpose() * normal.gains_right);
  const Eigen::VectorXd log_gains = of_gains.Solve(normal.gains_right - normal.mixed * terms);
  if (!terms.allFinite() || !log_gains.allFinite()) return false;
  light = {log_gains, terms, {}, {}};
  if (!has_spot) return true;
  Eigen::MatrixXd hills = Eigen::MatrixXd::Zero(left.rows(), kSpotTerms);
  hills.middleRows<kSpotTerms>(kSmoothDirectionTerms).setIdentity();
  const Eigen::MatrixXd covariance = geo::SolveSymmetric(left, hills);
  const Eigen::MatrixXd of_hills = covariance.middleRows<kSpotTerms>(kSmoothDirectionTerms);
  light.terms_by_hill = geo::SolveSymmetric(of_hills, covariance.transpose()).transpose();
  light.gains_by_hill = -eliminated * light.terms_by_hill;
  if (!light.terms_by_hill.allFinite() || !light.gains_by_hill.allFinite()) light.terms_by_hill.resize(0, 0);
  return true;
}

}  // namespace

double Explained(const ExposureSample& sample, const LightTerms& terms, const Eigen::VectorXd& log_gains,
                 const Eigen::VectorXd& of_terms) {
  const auto own = OwnBasis(sample, terms);
  const OwnTerms at(terms, sample.photo);
  double value = -log_gains[static_cast<Eigen::Index>(sample.photo)];
  for (std::size_t i = 0; i < at.count(); ++i) value += own[i] * of_terms[at[i]];
  return value;
}

double SampleWeight(double misfit) {
  return 1.0 / (1.0 + (misfit / kRobustScale) * (misfit / kRobustScale));  // Cauchy
}

std::vector<double> MisfitsOf(const std::vector<ExposureSample>& samples, std::size_t channel,
                              const LightTerms& terms, const SolvedLight& light) {
  std::vector<double> misfits(samples.size());
  std::vector<double> left;
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    end = EndOfSpot(samples, begin);
    left.clear();
    for (std::size_t s = begin; s < end; ++s)
      left.push_back(static_cast<double>(samples[s].log_value[channel]) -
                     Explained(samples[s], terms, light.log_gains, light.terms));
    const double centre = MedianOfMisfits(left);
    for (std::size_t s = begin; s < end; ++s) misfits[s] = left[s - begin] - centre;
  }
  return misfits;
}

SolvedLight SolveLight(const std::vector<ExposureSample>& samples, std::size_t channel,
                       const LightTerms& terms) {
  SolvedLight light{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(terms.photos())),
                    Eigen::VectorXd::Zero(static_cast<Eigen::Index>(terms.count())),
                    {},
                    {}};
  std::vector<double> weights(samples.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    Normal normal(terms.photos(), terms.count());
    AddPriors(terms, light.log_gains, normal);
    SpotAdder adder(terms, channel, normal);
    for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
      end = EndOfSpot(samples, begin);
      adder.Add(samples.data() + begin, samples.data() + end, weights.data() + begin);
    }
    if (!Solve(normal, terms.directions.hot_spot.has_value(), light)) return light;
    const std::vector<double> misfits = MisfitsOf(samples, channel, terms, light);
    for (std::size_t s = 0; s < samples.size(); ++s) weights[s] = SampleWeight(misfits[s]);
  }
  return light;
}

}  // namespace skyquilt::render
