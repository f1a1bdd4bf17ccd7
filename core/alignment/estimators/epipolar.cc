#include "core/alignment/estimators/epipolar.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "core/geo/solvers/dense_solvers.h"
#include "core/poses/so3.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHomographyConfidence = 0.999;
constexpr int kHomographyRefinements = 3;
constexpr double kMinDepth = 1e-3;  // of the middle's: nearer to the horizon nothing is believed

// To the mean zero and the mean distance of sqrt(2).
Matrix3d Unit(const std::vector<RayPair>& pairs, Vector2d RayPair::*side) {
  Vector2d mean = Vector2d::Zero();
  for (const RayPair& pair : pairs) mean += pair.*side;
  mean /= static_cast<double>(pairs.size());
  double spread = 0.0;
  for (const RayPair& pair : pairs) spread += (pair.*side - mean).norm();
  spread /= static_cast<double>(pairs.size());
  const double scale = spread > 1e-12 ? std::sqrt(2.0) / spread : 1.0;
  Matrix3d unit;
  unit << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return unit;
}

// The same; nothing where they lie in one place.
std::optional<Matrix3d> Normaliser(const std::vector<RayPair>& pairs, Vector2d RayPair::*side) {
  const auto count = static_cast<double>(pairs.size());
  Vector2d mean = Vector2d::Zero();
  for (const RayPair& pair : pairs) mean += pair.*side / count;
  double distance = 0.0;
  for (const RayPair& pair : pairs) distance += (pair.*side - mean).norm() / count;
  if (distance < 1e-9) return std::nullopt;
  const double scale = std::sqrt(2.0) / distance;
  Matrix3d normaliser;
  normaliser << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return normaliser;
}

// The map whose nine numbers the pairs, each side normalised, leave least of; nothing where they leave a
// second one `open_share` of the most.
std::optional<Matrix3d> LeastMap(const std::vector<RayPair>& pairs, double open_share,
                                 const Matrix3d& of_first, const Matrix3d& of_second) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (const RayPair& pair : pairs) {
    const Vector3d a = of_first * pair.first.homogeneous();
    const Vector3d b = of_second * pair.second.homogeneous();
    Eigen::Matrix<double, 2, 9> rows;
    rows << a.transpose(), Eigen::RowVector3d::Zero(), -b.x() * a.transpose(), Eigen::RowVector3d::Zero(),
        a.transpose(), -b.y() * a.transpose();
    normal += rows.transpose() * rows;
  }
  const geo::SymmetricEigen eigen = geo::EigenOfSymmetric(normal);
  if (!eigen.converged || eigen.values[1] < open_share * eigen.values[8]) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> found = eigen.vectors.col(0);
  const Matrix3d unit = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(found.data());
  const Matrix3d map = of_second.inverse() * unit * of_first;
  return map;
}

std::vector<int> FindInliers(const std::vector<RayPair>& pairs, const Matrix3d& second_from_first,
                             double tolerance) {
  std::vector<int> inliers;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Vector3d mapped = second_from_first * pairs[k].first.homogeneous();
    if (mapped.z() < kMinDepth * second_from_first(2, 2)) continue;
    const Vector2d place = mapped.hnormalized();
    if ((place - pairs[k].second).norm() <= tolerance) inliers.push_back(static_cast<int>(k));
  }
  return inliers;
}

std::vector<RayPair> Chosen(const std::vector<RayPair>& pairs, const std::vector<int>& which) {
  std::vector<RayPair> chosen;
  for (const int k : which) chosen.push_back(pairs[k]);
  return chosen;
}

int InFront(const geo::Rigid3& pose, const std::vector<RayPair>& pairs, const std::vector<int>& used) {
  int in_front = 0;
  for (const int k : used) {
    const std::optional<Vector2d> depths = Depths(pose, pairs[k]);
    in_front += depths && depths->x() > 0.0 && depths->y() > 0.0 ? 1 : 0;
  }
  return in_front;
}

// b' E a, and the square of how it grows with the pair's places.
std::pair<double, double> Apart(const Matrix3d& essential, const RayPair& pair) {
  const Vector3d a = pair.first.homogeneous(), b = pair.second.homogeneous();
  const Vector3d ea = essential * a;
  const Vector3d eb = essential.transpose() * b;
  return {b.dot(ea), ea.head<2>().squaredNorm() + eb.head<2>().squaredNorm()};
}

// Polynomials in three unknowns of an essential matrix x X + y Y + z Z + W, by the order of their terms
// below.
constexpr int kLinear = 4, kQuadratic = 10, kCubic = 20;
using Linear = Eigen::Matrix<double, kLinear, 1>;        // x, y, z, 1
using Quadratic = Eigen::Matrix<double, kQuadratic, 1>;  // xx, xy, xz, yy, yz, zz, x, y, z, 1
// xxx, xxy, xxz, xyy, xyz, xzz, yyy, yyz, yzz, zzz, and then as the quadratic.
using Cubic = Eigen::Matrix<double, kCubic, 1>;

constexpr int kLinearTimesLinear[kLinear][kLinear] = {{0, 1, 2, 6}, {1, 3, 4, 7}, {2, 4, 5, 8}, {6, 7, 8, 9}};
constexpr int kQuadraticTimesLinear[kQuadratic][kLinear] = {
    {0, 1, 2, 10}, {1, 3, 4, 11},    {2, 4, 5, 12},    {3, 6, 7, 13},    {4, 7, 8, 14},
    {5, 8, 9, 15}, {10, 11, 12, 16}, {11, 13, 14, 17}, {12, 14, 15, 18}, {16, 17, 18, 19}};

Quadratic Times(const Linear& a, const Linear& b) {
  Quadratic product = Quadratic::Zero();
  for (int i = 0; i < kLinear; ++i) {
    for (int j = 0; j < kLinear; ++j) product[kLinearTimesLinear[i][j]] += a[i] * b[j];
  }
  return product;
}

Cubic Times(const Quadratic& a, const Linear& b) {
  Cubic product = Cubic::Zero();
  for (int i = 0; i < kQuadratic; ++i) {
    for (int j = 0; j < kLinear; ++j) product[kQuadraticTimesLinear[i][j]] += a[i] * b[j];
  }
  return product;
}

}  // namespace

std::optional<Matrix3d> FitHomography(const std::vector<RayPair>& pairs, const std::vector<int>& used) {
  if (used.size() < 4) return std::nullopt;
  const std::vector<RayPair> chosen = Chosen(pairs, used);
  const Matrix3d of_first = Unit(chosen, &RayPair::first);
  const Matrix3d of_second = Unit(chosen, &RayPair::second);
  // Two ways to map them alike well: three of four lie on a line.
  const std::optional<Matrix3d> homography = LeastMap(chosen, 1e-9, of_first, of_second);
  if (!homography) return std::nullopt;
  const double determinant = homography->determinant();
  const double size = homography->norm();
  if (!std::isfinite(size) || std::abs(determinant) < 1e-9 * size * size * size) return std::nullopt;
  return *homography / std::cbrt(determinant);  // determinant 1: no mirror, and points in front stay there
}

std::optional<Matrix3d> FitHomography(const std::vector<RayPair>& pairs) {
  if (pairs.size() < 4) return std::nullopt;
  const std::optional<Matrix3d> of_first = Normaliser(pairs, &RayPair::first);
  const std::optional<Matrix3d> of_second = Normaliser(pairs, &RayPair::second);
  if (!of_first || !of_second) return std::nullopt;
  std::optional<Matrix3d> homography = LeastMap(pairs, 1e-12, *of_first, *of_second);
  if (!homography || std::abs((*homography)(2, 2)) < 1e-12 * homography->norm()) return std::nullopt;
  *homography /= (*homography)(2, 2);
  return homography;
}

std::optional<RobustFit> RobustHomography(const std::vector<RayPair>& pairs, double tolerance,
                                          int max_trials) {
  const auto count = static_cast<int>(pairs.size());
  if (count < 8) return std::nullopt;
  std::vector<cv::Point2d> from, to;
  for (const RayPair& pair : pairs) {
    from.emplace_back(pair.first.x(), pair.first.y());
    to.emplace_back(pair.second.x(), pair.second.y());
  }
  const cv::Mat found = cv::findHomography(from, to, cv::USAC_MAGSAC, tolerance, cv::noArray(), max_trials,
                                           kHomographyConfidence);
  if (found.empty()) return std::nullopt;
  RobustFit best;
  Matrix3d& map = best.second_from_first;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) map(r, c) = found.at<double>(r, c);
  }
  if (!map.allFinite() || std::abs(map(2, 2)) < 1e-12 * map.norm()) return std::nullopt;
  map /= map(2, 2);
  best.inliers = FindInliers(pairs, map, tolerance);
  for (int round = 0; round < kHomographyRefinements && best.inliers.size() >= 4; ++round) {
    const std::optional<Matrix3d> refined = FitHomography(Chosen(pairs, best.inliers));
    if (!refined) break;
    std::vector<int> inliers = FindInliers(pairs, *refined, tolerance);
    if (inliers.size() < best.inliers.size()) break;
    best = {*refined, std::move(inliers)};
  }
  if (static_cast<double>(best.inliers.size()) <= 5.9 + 0.22 * count) return std::nullopt;
  return best;
}

double TransferError2(const Matrix3d& second_from_first, const RayPair& pair) {
  const Vector3d mapped = second_from_first * pair.first.homogeneous();
  if (mapped.z() <= 1e-9) return std::numeric_limits<double>::infinity();
  return (mapped.head<2>() / mapped.z() - pair.second).squaredNorm();
}

std::optional<Vector2d> Depths(const geo::Rigid3& pose, const RayPair& pair) {
  // depth2 * b = depth1 * R a + t
  const Vector3d a = pose.rotation * pair.first.homogeneous();
  const Vector3d b = pair.second.homogeneous();
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
  const double determinant = aa * bb - ab * ab;
  if (determinant < 1e-14 * aa * bb) return std::nullopt;
  const double at = a.dot(pose.translation), bt = b.dot(pose.translation);
  return Vector2d((-at * bb + bt * ab) / determinant, (aa * bt - ab * at) / determinant);
}

std::vector<geo::Rigid3> PosesOfHomography(const Matrix3d& second_from_first,
                                           const std::vector<RayPair>& pairs, const std::vector<int>& used) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(second_from_first.transpose() * second_from_first);
  Matrix3d v;  // by falling singular value
  for (int k = 0; k < 3; ++k) v.col(k) = solver.eigenvectors().col(2 - k);
  if (v.determinant() < 0.0) v.col(2) = -v.col(2);
  const double middle = solver.eigenvalues()[1];
  if (middle <= 0.0) return {};
  const Matrix3d h = second_from_first / std::sqrt(middle);
  const double most = solver.eigenvalues()[2] / middle, least = solver.eigenvalues()[0] / middle;
  std::vector<geo::Rigid3> poses;
  if (most - least < 1e-10) {
    geo::Rigid3 turned;
    turned.rotation = Eigen::Quaterniond(h).normalized();
    return {turned};
  }
  const double a = std::sqrt(std::max(0.0, 1.0 - least)), c = std::sqrt(std::max(0.0, most - 1.0));
  const double length = std::sqrt(most - least);
  for (const double sign : {1.0, -1.0}) {
    const Vector3d u = (a * v.col(0) + sign * c * v.col(2)) / length;
    Matrix3d from, to;
    from << v.col(1), u, v.col(1).cross(u);
    to << h * v.col(1), h * u, (h * v.col(1)).cross(h * u);
    const Matrix3d rotation = to * from.transpose();
    const Vector3d shift = (h - rotation) * from.col(2);
    geo::Rigid3 pose;
    pose.rotation = Eigen::Quaterniond(rotation).normalized();
    const double size = shift.norm();
    if (size < 1e-9) {
      poses.push_back(pose);
      continue;
    }
    for (const double way : {1.0, -1.0}) {
      pose.translation = way / size * shift;
      if (10 * InFront(pose, pairs, used) >= 9 * static_cast<int>(used.size())) poses.push_back(pose);
    }
  }
  return poses;
}

std::vector<Matrix3d> EssentialsOfFive(const std::array<RayPair, 5>& pairs) {
  Eigen::Matrix<double, 9, 9> rows = Eigen::Matrix<double, 9, 9>::Zero();
  for (int k = 0; k < 5; ++k) {
    const Vector3d a = pairs[k].first.homogeneous();
    const Vector3d b = pairs[k].second.homogeneous();
    for (int r = 0; r < 3; ++r) rows.block<1, 3>(k, 3 * r) = b[r] * a.transpose();
  }
  const Eigen::Matrix<double, 9, 9> q = geo::OrthonormalBasis(rows.topRows<5>().transpose());
  // The matrix's entries, each linear in the unknowns.
  Linear entry[3][3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      for (int m = 0; m < kLinear; ++m) entry[r][c][m] = q(3 * r + c, 5 + m);
    }
  }
  Quadratic squares[3][3];  // E E'
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      squares[r][c] =
          Times(entry[r][0], entry[c][0]) + Times(entry[r][1], entry[c][1]) + Times(entry[r][2], entry[c][2]);
    }
  }
  const Quadratic half_trace = 0.5 * (squares[0][0] + squares[1][1] + squares[2][2]);
  for (int r = 0; r < 3; ++r) squares[r][r] -= half_trace;
  Eigen::Matrix<double, 10, kCubic> constraints;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      constraints.row(3 * r + c) = (Times(squares[r][0], entry[0][c]) + Times(squares[r][1], entry[1][c]) +
                                    Times(squares[r][2], entry[2][c]))
                                       .transpose();
    }
  }
  const auto minor = [&](int c, int d) -> Quadratic {
    return Times(entry[1][c], entry[2][d]) - Times(entry[1][d], entry[2][c]);
  };
  constraints.row(9) =
      (Times(minor(1, 2), entry[0][0]) + Times(minor(2, 0), entry[0][1]) + Times(minor(0, 1), entry[0][2]))
          .transpose();
  // The cubic terms by the others, and with that what multiplying by x does to the ten others.
  const std::optional<Eigen::MatrixXd> reduced =
      geo::SolveSquare(constraints.leftCols<10>(), constraints.rightCols<10>());
  if (!reduced) return {};
  Eigen::MatrixXd action = Eigen::MatrixXd::Zero(10, 10);
  for (int r = 0; r < 6; ++r) action.row(r) = -reduced->row(r);
  action(6, 0) = action(7, 1) = action(8, 2) = action(9, 6) = 1.0;
  const geo::ComplexEigen eigen = geo::EigenOfSquare(action, true);
  if (!eigen.converged) return {};
  std::vector<Matrix3d> found;
  for (int k = 0; k < 10; ++k) {
    const std::complex<double> value = eigen.values[k];
    if (std::abs(value.imag()) > 1e-8 * (1.0 + std::abs(value.real()))) continue;
    const Eigen::Matrix<double, 10, 1> vector = eigen.vectors.col(k).real();
    if (std::abs(vector[9]) < 1e-12) continue;
    Linear at;
    at << vector[6] / vector[9], vector[7] / vector[9], vector[8] / vector[9], 1.0;
    Matrix3d essential;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) essential(r, c) = entry[r][c].dot(at);
    }
    const double size = essential.norm();
    if (std::isfinite(size) && size > 1e-12) found.push_back(essential / size);
  }
  return found;
}

geo::Rigid3 PoseOfEssential(const Matrix3d& essential, const std::vector<RayPair>& pairs,
                            const std::vector<int>& used) {
  const Eigen::JacobiSVD<Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0.0) u = -u;
  if (v.determinant() < 0.0) v = -v;
  Matrix3d quarter;
  quarter << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  geo::Rigid3 best;
  int most = -1;
  for (const Matrix3d& turn : {quarter, Matrix3d(quarter.transpose())}) {
    for (const double way : {1.0, -1.0}) {
      geo::Rigid3 pose;
      pose.rotation = Eigen::Quaterniond(Matrix3d(u * turn * v.transpose())).normalized();
      pose.translation = way * u.col(2);
      const int in_front = InFront(pose, pairs, used);
      if (in_front > most) {
        most = in_front;
        best = pose;
      }
    }
  }
  return best;
}

Matrix3d EssentialOfPose(const geo::Rigid3& pose) {
  return poses::Skew(pose.translation) * pose.rotation.toRotationMatrix();
}

double Sampson2(const Matrix3d& essential, const RayPair& pair) {
  const auto [residual, slope2] = Apart(essential, pair);
  return slope2 > 1e-18 ? residual * residual / slope2 : std::numeric_limits<double>::infinity();
}

geo::Rigid3 RefinePose(const geo::Rigid3& start, const std::vector<RayPair>& pairs,
                       const std::vector<int>& used, double width, int steps) {
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  if (start.translation.squaredNorm() < 0.5) return start;
  geo::Rigid3 pose = start;
  const auto nudged = [](const geo::Rigid3& from, const Vector5d& by) {
    geo::Rigid3 to;
    to.rotation = (geo::RotationFromVector(by.head<3>()) * from.rotation).normalized();
    const Vector3d across = from.translation.unitOrthogonal();
    to.translation =
        (from.translation + by[3] * across + by[4] * from.translation.cross(across)).normalized();
    return to;
  };
  const auto residual = [](const Matrix3d& essential, const RayPair& pair) {
    const auto [apart, slope2] = Apart(essential, pair);
    return apart / std::sqrt(std::max(1e-18, slope2));
  };
  const auto cost = [&](const geo::Rigid3& of) {
    const Matrix3d essential = EssentialOfPose(of);
    double sum = 0.0;
    for (const int k : used) {
      sum += std::log1p(Sampson2(essential, pairs[k]) / (width * width));
    }
    return sum;
  };
  double now = cost(pose);
  double damping = 1e-4;
  constexpr double kNudge = 1e-6;
  for (int step = 0; step < steps; ++step) {
    const Matrix3d essential = EssentialOfPose(pose);
    Matrix3d moved[5];
    for (int axis = 0; axis < 5; ++axis)
      moved[axis] = EssentialOfPose(nudged(pose, kNudge * Vector5d::Unit(axis)));
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Vector5d right = Vector5d::Zero();
    for (const int k : used) {
      const RayPair& pair = pairs[k];
      const double here = residual(essential, pair);
      Vector5d slope;
      for (int axis = 0; axis < 5; ++axis) slope[axis] = (residual(moved[axis], pair) - here) / kNudge;
      const double weight = 1.0 / (1.0 + here * here / (width * width));
      normal += weight * slope * slope.transpose();
      right -= weight * here * slope;
    }
    Eigen::Matrix<double, 5, 5> damped = normal;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff();
    const Vector5d by = geo::SolveSymmetric(damped, right);
    const geo::Rigid3 next = nudged(pose, by);
    const double then = cost(next);
    if (then < now) {
      pose = next;
      damping = std::max(1e-9, 0.1 * damping);
      if (now - then < 1e-6 * now) break;
      now = then;
    } else {
      damping *= 10.0;
    }
  }
  return pose;
}

}  // namespace skyquilt::alignment
