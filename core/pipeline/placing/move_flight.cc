#include "core/pipeline/placing/move_flight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <utility>
#include <variant>

#include "core/alignment/bundle/control_points.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/view.h"
#include "core/base/median.h"
#include "core/flight/remarks/because.h"
#include "core/geo/bounds.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::Similarity3;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLevel = 1e-9;
// Places nearer together than this share of the flight's extent say too little of scale and north.
constexpr double kMinPairSpread = 0.05;
// Of the pairs' spread, by which one that was pointed at with care may be off.
constexpr double kAgreedPairShare = 0.1;

Similarity3 InverseOf(const Similarity3& similarity) {
  Similarity3 inverse;
  inverse.scale = 1.0 / similarity.scale;
  inverse.rotation = similarity.rotation.conjugate();
  inverse.shift = -(inverse.scale * (inverse.rotation * similarity.shift));
  return inverse;
}

std::vector<alignment::View> ViewsOf(const FlightFacts& known) {
  std::vector<alignment::View> views;
  for (const AlignedPhoto& photo : known.flight.photos) {
    views.push_back(
        {photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m, photo.readout_motion});
  }
  return views;
}

struct NamesAndTies {
  std::vector<std::string> names;
  alignment::PhotoSet tied;

  explicit NamesAndTies(const FlightFacts& known) {
    for (const AlignedPhoto& photo : known.flight.photos) {
      names.push_back(photo.photo.name);
      tied.Append(photo.placement == alignment::Placement::kAligned);
    }
  }
};

// The box that the ground is known in: a grid's own; for a plane below what the cameras may see of it.
geo::Bounds2 BoundsOfGround(const FlightFacts& facts) {
  const ground::GroundSurface& ground = facts.ground;
  geo::Bounds2 bounds;
  if (!ground.IsPlane()) {
    bounds.Include(ground.SouthWest());
    bounds.Include(
        Vector2d(ground.SouthWest() + ground.CellSize() * Vector2d(ground.Columns() - 1, ground.Rows() - 1)));
    return bounds;
  }
  for (const AlignedPhoto& photo : facts.flight.photos) {
    const Vector2d below = photo.cam_from_enu.TargetOriginInSource().head<2>();
    const double reach_m = 3.0 * std::max(1.0, photo.height_above_ground_m);
    bounds.Include(Vector2d(below - Vector2d::Constant(reach_m)));
    bounds.Include(Vector2d(below + Vector2d::Constant(reach_m)));
  }
  return bounds;
}

double DiagonalM(const geo::Bounds2& bounds) {
  return bounds.IsEmpty() ? 0.0 : std::hypot(bounds.Width(), bounds.Height());
}

ground::GroundSurface Moved(const FlightFacts& facts, const Similarity3& move) {
  const ground::GroundSurface& ground = facts.ground;
  const double mean_z_m = (move * Vector3d(0.0, 0.0, ground.MeanHeight())).z();
  const bool is_level = (move.rotation * Vector3d::UnitZ() - Vector3d::UnitZ()).norm() < kLevel;
  if (is_level && ground.IsPlane()) return ground::GroundSurface::Plane(mean_z_m);
  const geo::Bounds2 was = BoundsOfGround(facts);
  geo::Bounds2 bounds;
  for (const Vector2d& corner :
       {was.min, Vector2d(was.max.x(), was.min.y()), Vector2d(was.min.x(), was.max.y()), was.max}) {
    bounds.Include((move * Vector3d(corner.x(), corner.y(), ground.MeanHeight())).head<2>().eval());
  }
  constexpr double kCellsOfAPlane = 64.0;
  const double cell_m = ground.IsPlane() ? std::max(bounds.Width(), bounds.Height()) / kCellsOfAPlane
                                         : move.scale * ground.CellSize();
  const int columns = static_cast<int>(std::ceil(bounds.Width() / cell_m)) + 1;
  const int rows = static_cast<int>(std::ceil(bounds.Height() / cell_m)) + 1;
  const Similarity3 back = InverseOf(move);
  // Up and down leans with the turn: what lies below a place is sought from the height found before.
  const auto height_at = [&](double x, double y) {
    constexpr int kRounds = 8;
    double z = mean_z_m;
    for (int round = 0; round < (is_level ? 1 : kRounds); ++round) {
      Vector3d old = back * Vector3d(x, y, z);
      old.z() = ground.HeightAt(old.head<2>());
      const Vector3d found = move * old;
      z = found.z();
    }
    return z;
  };
  std::vector<float> heights_m;
  double sum_m = 0.0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double z = height_at(bounds.min.x() + column * cell_m, bounds.min.y() + row * cell_m);
      heights_m.push_back(static_cast<float>(z));
      sum_m += z;
    }
  }
  return ground::GroundSurface::Grid(bounds.min, cell_m, columns, rows, std::move(heights_m),
                                     is_level ? mean_z_m : sum_m / (static_cast<double>(columns) * rows));
}

}  // namespace

Similarity3 AboutVertical(const alignment::GroundSimilarity& move, double z_m) {
  Similarity3 similarity;
  similarity.scale = std::abs(move.turn_and_scale);
  similarity.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(std::arg(move.turn_and_scale), Vector3d::UnitZ()));
  similarity.shift = {move.shift.real(), move.shift.imag(), z_m - similarity.scale * z_m};
  return similarity;
}

void MoveFlight(const Similarity3& new_from_old, FlightFacts& facts) {
  facts.ground = Moved(facts, new_from_old);
  facts.flight.ground_z_in_enu_m = (new_from_old * Vector3d(0.0, 0.0, facts.flight.ground_z_in_enu_m)).z();
  for (AlignedPhoto& photo : facts.flight.photos) {
    photo.cam_from_enu = new_from_old.Moved(photo.cam_from_enu);
    photo.height_above_ground_m *= new_from_old.scale;
    photo.error_radius_m *= new_from_old.scale;
    Eigen::Vector3d& shift_m = photo.readout_motion.shift_in_enu_m;
    shift_m = new_from_old.scale * (new_from_old.rotation * shift_m);
  }
  facts.appearance.reset();
  facts.seams.reset();
}

std::vector<MarkedPoint> MarkedPointsOf(const FlightFacts& known,
                                        const std::vector<alignment::ControlPoint>& control,
                                        std::vector<alignment::ControlReport>& reports) {
  const NamesAndTies photos_of(known);
  const std::vector<alignment::View> views = ViewsOf(known);
  const alignment::MarkedPhotos photos(photos_of.names, views, photos_of.tied);
  std::vector<MarkedPoint> marked;
  for (const alignment::ControlPoint& point : control) {
    const std::optional<alignment::Track> track = photos.TrackOf(point, reports.emplace_back());
    if (track) marked.push_back({track->point_in_enu, point, reports.size() - 1});
  }
  return marked;
}

std::vector<std::vector<alignment::ControlMarkReport>> MarkResiduals(
    const FlightFacts& placed, const std::vector<alignment::ControlPoint>& control) {
  const NamesAndTies known(placed);
  const std::vector<alignment::View> views = ViewsOf(placed);
  const alignment::MarkedPhotos photos(known.names, views, known.tied);
  std::vector<std::vector<alignment::ControlMarkReport>> residuals;
  for (const alignment::ControlPoint& point : control) {
    alignment::ControlReport ignored;
    const std::optional<alignment::Track> track = photos.TrackOf(point, ignored);
    Vector3d surveyed = placed.flight.frame.EnuAtHeight(point.position, 0.0);
    surveyed = placed.flight.frame.EnuAtHeight(
        point.position, track ? track->point_in_enu.z() : placed.ground.HeightAt(surveyed.head<2>()));
    residuals.push_back(photos.ResidualsOf(point, surveyed, track));
  }
  return residuals;
}

double MedianGsdM(const FlightFacts& known) {
  std::vector<double> gsds_m;
  for (const alignment::View& view : ViewsOf(known)) gsds_m.push_back(view.GsdM());
  return MedianIfAny(std::move(gsds_m)).value_or(0.0);
}

double ExtentM(const FlightFacts& known) {
  geo::Bounds2 bounds;
  for (const AlignedPhoto& photo : known.flight.photos) {
    bounds.Include(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  return DiagonalM(bounds);
}

void TellOfControl(const std::vector<alignment::ControlReport>& control, const Vector3d& moved_m,
                   FlightFacts& facts) {
  if (!facts.align_report) return;
  facts.align_report->control = control;
  Vector3d& bias_m = facts.align_report->position_bias_m;
  bias_m = facts.is_placed ? Vector3d(bias_m + moved_m) : Vector3d(Vector3d::Zero());
}

bool IsOfHand(const flight::Remark& said) {
  using flight::RemarkCode;
  if (said.code == RemarkCode::kSentences) {
    const auto first = said.values.find("first");
    const auto* within =
        first == said.values.end() ? nullptr : std::get_if<std::vector<flight::Remark>>(&first->second.is);
    return within != nullptr && std::any_of(within->begin(), within->end(), IsOfHand);
  }
  return said.code == RemarkCode::kPlacedByPairs || said.code == RemarkCode::kPlacedByOrigin ||
         said.code == RemarkCode::kPlacedByPhoto;
}

bool IsOfControl(const flight::Remark& said) {
  using flight::RemarkCode;
  constexpr std::array kCodes = {
      RemarkCode::kControlNotUsed,       RemarkCode::kControlFarOff,    RemarkCode::kControlFarOffAndNoted,
      RemarkCode::kControlNoted,         RemarkCode::kPlacedByControl,  RemarkCode::kMovedToControl,
      RemarkCode::kControlOfOtherPixels, RemarkCode::kControlElsewhere, RemarkCode::kControlPairDisagrees,
      RemarkCode::kControlHeightOff,     RemarkCode::kControlOverruled};
  return std::find(kCodes.begin(), kCodes.end(), said.code) != kCodes.end();
}

Result<MoveOfPairs> MoveByPairs(const FlightFacts& known, const std::vector<ShownPair>& pairs) {
  const double ground_z_m = known.ground.MeanHeight();
  const geo::LatLon first = pairs.front().is;
  MoveOfPairs move{.new_from_old = {},
                   .frame = geo::LocalFrame(
                       {first.lat_deg, first.lon_deg, known.flight.frame.origin().height_ellipsoid_m})};
  std::vector<std::pair<std::complex<double>, std::complex<double>>> places;
  geo::Bounds2 shown, is;
  for (const ShownPair& pair : pairs) {
    const Vector2d from = known.flight.frame.EnuAtHeight(pair.shown, ground_z_m).head<2>();
    const Vector2d to = move.frame.EnuAtHeight(pair.is, ground_z_m).head<2>();
    shown.Include(from);
    is.Include(to);
    places.emplace_back(std::complex(from.x(), from.y()), std::complex(to.x(), to.y()));
  }
  const double spread_m = DiagonalM(shown);
  if (pairs.size() > 1 && (spread_m < kMinPairSpread * ExtentM(known) || !(DiagonalM(is) > 0.0))) {
    return flight::Because(
        ErrorCode::kUnprocessable,
        {flight::RemarkCode::kFailPlacesTooNear,
         {{"share_percent", spread_m > 0.0 ? 100.0 * spread_m / std::max(ExtentM(known), spread_m) : 0.0}}});
  }
  const alignment::GroundSimilarity fitted = alignment::FitSimilarity(places);
  move.new_from_old = AboutVertical(fitted, ground_z_m);
  if (pairs.size() > 2) {
    for (const auto& [from, to] : places) move.miss_m = std::max(move.miss_m, std::abs(fitted * from - to));
    if (move.miss_m > kAgreedPairShare * DiagonalM(is)) {
      return flight::Because(ErrorCode::kUnprocessable,
                             {flight::RemarkCode::kFailPlacesContradict, {{"apart_m", move.miss_m}}});
    }
  }
  return move;
}

}  // namespace skyquilt::pipeline
