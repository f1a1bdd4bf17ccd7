#include "core/pipeline/placing/move_by_pairs.h"

#include <algorithm>
#include <complex>
#include <numeric>

#include "core/flight/remarks/because.h"
#include "core/geo/bounds.h"
#include "core/pipeline/placing/move_flight.h"

namespace skyquilt::pipeline {
namespace {

using Eigen::Vector3d;

// Places nearer together than this share of the flight's extent say too little of scale and north.
constexpr double kMinPairSpread = 0.05;
// Of the pairs' spread, by which one that was pointed at with care may be off.
constexpr double kAgreedPairShare = 0.1;

std::complex<double> OnPlane(const Vector3d& point) { return {point.x(), point.y()}; }

double SpreadOfM(const std::vector<Vector3d>& points) {
  geo::Bounds2 bounds;
  for (const Vector3d& point : points) bounds.Include(point.head<2>());
  return std::hypot(bounds.Width(), bounds.Height());
}

}  // namespace

Result<MoveOfPairs> MoveByPairs(const FlightFacts& known, const std::vector<ShownPair>& pairs) {
  const double ground_z_m = known.ground.MeanHeight();
  const geo::LatLon first = pairs.front().is;
  MoveOfPairs move{.new_from_old = {},
                   .frame = geo::LocalFrame(
                       {first.lat_deg, first.lon_deg, known.flight.frame.origin().height_ellipsoid_m})};
  std::vector<Vector3d> shown, is;
  for (const ShownPair& pair : pairs) {
    shown.push_back(known.flight.frame.EnuAtHeight(pair.shown, ground_z_m));
    is.push_back(move.frame.EnuAtHeight(pair.is, ground_z_m));
  }
  std::complex<double> factor(1.0, 0.0);
  const auto count = static_cast<double>(pairs.size());
  const Vector3d shown_middle = std::accumulate(shown.begin(), shown.end(), Vector3d(0, 0, 0)) / count;
  const Vector3d is_middle = std::accumulate(is.begin(), is.end(), Vector3d(0, 0, 0)) / count;
  if (pairs.size() > 1) {
    const double spread_m = SpreadOfM(shown);
    if (spread_m < kMinPairSpread * ExtentM(known) || !(SpreadOfM(is) > 0.0)) {
      return flight::Because(
          ErrorCode::kUnprocessable,
          {flight::RemarkCode::kFailPlacesTooNear,
           {{"share_percent",
             spread_m > 0.0 ? 100.0 * spread_m / std::max(ExtentM(known), spread_m) : 0.0}}});
    }
    std::complex<double> product(0.0, 0.0);
    double square = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const std::complex<double> from = OnPlane(shown[k] - shown_middle);
      product += OnPlane(is[k] - is_middle) * std::conj(from);
      square += std::norm(from);
    }
    factor = product / square;
  }
  move.new_from_old.scale = std::abs(factor);
  move.new_from_old.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(std::arg(factor), Vector3d::UnitZ()));
  move.new_from_old.shift = is_middle - move.new_from_old.scale * (move.new_from_old.rotation * shown_middle);
  if (pairs.size() > 2) {
    for (std::size_t k = 0; k < pairs.size(); ++k)
      move.miss_m = std::max(move.miss_m, (move.new_from_old * shown[k] - is[k]).head<2>().norm());
    if (move.miss_m > kAgreedPairShare * SpreadOfM(is)) {
      return flight::Because(ErrorCode::kUnprocessable,
                             {flight::RemarkCode::kFailPlacesContradict, {{"apart_m", move.miss_m}}});
    }
  }
  return move;
}

}  // namespace skyquilt::pipeline
