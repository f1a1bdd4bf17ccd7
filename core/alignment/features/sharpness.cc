#include "core/alignment/features/sharpness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {
namespace {

constexpr double kCoarser = 4.0;
constexpr int kDirections = 36;
constexpr double kSmoothedPx = 1.0;
constexpr double kShareOfCells = 0.75;
constexpr double kMinDetail = 0.1;  // grey levels squared: of a picture without anything to see
constexpr int kSmearDirections = 18;
constexpr std::size_t kMinSharedCells = 12;
constexpr double kTrace = 0.1;
constexpr double kMaxScaleRatio = 1.25;

cv::Rect CellOf(const cv::Mat& picture, int column, int row) {
  const auto from = [](int size, int number) { return size * number / kDetailCells; };
  return {cv::Point(from(picture.cols, column), from(picture.rows, row)),
          cv::Point(from(picture.cols, column + 1), from(picture.rows, row + 1))};
}

// The second derivatives of a picture.
class Curvature {
 public:
  explicit Curvature(const cv::Mat& grey) {
    // Without this, noise is detail, and along the diagonals there is less of it.
    cv::Mat smooth;
    grey.convertTo(smooth, CV_32F);
    cv::GaussianBlur(smooth, smooth, {}, kSmoothedPx);
    cv::Sobel(smooth, xx_, CV_32F, 2, 0);
    cv::Sobel(smooth, xy_, CV_32F, 1, 1);
    cv::Sobel(smooth, yy_, CV_32F, 0, 2);
  }

  DirectedEnergy In(int column, int row) const {
    const cv::Rect cell = CellOf(xx_, column, row);
    const cv::Mat xx = xx_(cell), xy = xy_(cell), yy = yy_(cell);
    const double pixels = cell.area();
    return {static_cast<float>(xx.dot(xx) / pixels), static_cast<float>(4.0 * xx.dot(xy) / pixels),
            static_cast<float>((4.0 * xy.dot(xy) + 2.0 * xx.dot(yy)) / pixels),
            static_cast<float>(4.0 * xy.dot(yy) / pixels), static_cast<float>(yy.dot(yy) / pixels)};
  }

 private:
  cv::Mat xx_, xy_, yy_;
};

double EnergyAlong(const DirectedEnergy& energy, double c, double s) {
  return energy[0] * c * c * c * c + energy[1] * c * c * c * s + energy[2] * c * c * s * s +
         energy[3] * c * s * s * s + energy[4] * s * s * s * s;
}

// Over all directions, the least and the most.
std::pair<double, double> Extremes(const DirectedEnergy& energy) {
  double least = std::numeric_limits<double>::max(), most = 0.0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle_rad = geo::kPi * k / kDirections;
    const double along = EnergyAlong(energy, std::cos(angle_rad), std::sin(angle_rad));
    least = std::min(least, along);
    most = std::max(most, along);
  }
  return {least, most};
}

int CellAt(const View& view, const Eigen::Vector2d& pixel) {
  const auto number = [](double at_px, int size_px) {
    return std::clamp(static_cast<int>((at_px + 0.5) / size_px * kDetailCells), 0, kDetailCells - 1);
  };
  return number(pixel.y(), view.intrinsics.height_px) * kDetailCells +
         number(pixel.x(), view.intrinsics.width_px);
}

struct SeenPlace {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d step;  // pixels a metre to the east and to the north
};

std::optional<SeenPlace> See(const View& view, const Eigen::Vector3d& place) {
  const auto at = [&](const Eigen::Vector3d& point) {
    return view.intrinsics.Project(view.cam_from_enu * point);
  };
  const double reach_m = view.GsdM();
  const auto pixel = at(place), east = at(place + reach_m * Eigen::Vector3d::UnitX()),
             north = at(place + reach_m * Eigen::Vector3d::UnitY());
  if (!pixel || !east || !north) return std::nullopt;
  SeenPlace seen{*pixel, {}};
  seen.step << (*east - *pixel) / reach_m, (*north - *pixel) / reach_m;
  return seen;
}

// As if the picture were of middle brightness: exposures differ. Where all detail lies in one direction, as
// in crop rows, a trace of it shows in the others, more or less as the rows lie in the pixels.
double DetailOf(const DirectedEnergy& energy, float brightness, const Eigen::Vector2d& along) {
  constexpr double kMiddleGrey = 128.0;
  const double gain = kMiddleGrey / (brightness + 1.0);
  const double mean = (3.0 * energy[0] + energy[2] + 3.0 * energy[4]) / 8.0;  // over all directions
  return gain * gain * (EnergyAlong(energy, along.x(), along.y()) + kTrace * mean + kMinDetail);
}

}  // namespace

PictureDetail MeasureDetail(int width_px, int height_px, const std::uint8_t* grey) {
  // A quarter of it must still hold the cells, or be a picture at all.
  if (std::min(width_px, height_px) < static_cast<int>(kCoarser) * (kDetailCells - 1)) return {};
  const cv::Mat picture(height_px, width_px, CV_8U, const_cast<std::uint8_t*>(grey));
  cv::Mat smooth, coarser;
  cv::GaussianBlur(picture, smooth, {}, 0.5 * kCoarser);
  cv::resize(smooth, coarser, {}, 1.0 / kCoarser, 1.0 / kCoarser, cv::INTER_AREA);
  if (coarser.cols < kDetailCells || coarser.rows < kDetailCells) return {};
  const Curvature fine(picture), coarse(coarser);
  PictureDetail detail;
  for (int row = 0; row < kDetailCells; ++row) {
    for (int column = 0; column < kDetailCells; ++column) {
      detail.push_back({fine.In(column, row), coarse.In(column, row),
                        static_cast<float>(cv::mean(picture(CellOf(picture, column, row)))[0])});
    }
  }
  return detail;
}

// Of the cells that are sharper than most: water and asphalt have no detail, but hardly fill a picture; a
// blurred one is sharp nowhere.
double SharpnessByItself(const PictureDetail& detail) {
  if (detail.empty()) return 0.0;
  std::vector<std::pair<double, double>> cells;  // coarse detail, sharpness
  for (const DetailCell& cell : detail) {
    const double coarse = Extremes(cell.coarse).second + kMinDetail;
    cells.emplace_back(coarse, Extremes(cell.fine).first / coarse);
  }
  std::sort(cells.begin(), cells.end());
  std::vector<double> sharpness;
  for (std::size_t k = cells.size() / 2; k < cells.size(); ++k) sharpness.push_back(cells[k].second);
  return Percentile(std::move(sharpness), kShareOfCells);
}

std::optional<double> SharpnessAgainst(const PictureDetail& own, const View& own_view,
                                       const PictureDetail& other, const View& other_view,
                                       const Relief& relief) {
  if (own.empty() || other.empty()) return std::nullopt;
  std::array<std::vector<double>, 2 * kSmearDirections> shares;  // of fine detail, then of coarse
  for (int k = 0; k < static_cast<int>(own.size()); ++k) {
    const Eigen::Vector2d middle =
        own_view.intrinsics.MiddleOfCell(k % kDetailCells, k / kDetailCells, kDetailCells);
    Eigen::Vector3d place;
    if (!MeetGround(own_view, relief, middle, &place)) continue;
    const std::optional<SeenPlace> in_own = See(own_view, place), in_other = See(other_view, place);
    if (!in_own || !in_other || !other_view.intrinsics.IsInImage(in_other->pixel)) continue;
    const DetailCell& own_cell = own[k];
    const DetailCell& other_cell = other[CellAt(other_view, in_other->pixel)];
    for (int d = 0; d < kSmearDirections; ++d) {
      const Eigen::Vector2d along(std::cos(geo::kPi * d / kSmearDirections),
                                  std::sin(geo::kPi * d / kSmearDirections));
      const Eigen::Vector2d own_step = in_own->step * along, other_step = in_other->step * along;
      const double ratio = (own_step.norm() / own_view.intrinsics.width_px) /
                           (other_step.norm() / other_view.intrinsics.width_px);
      if (ratio > kMaxScaleRatio || ratio < 1.0 / kMaxScaleRatio) continue;
      const auto compare = [&](const DirectedEnergy& own_energy, const DirectedEnergy& other_energy) {
        return DetailOf(own_energy, own_cell.brightness, own_step.normalized()) /
               DetailOf(other_energy, other_cell.brightness, other_step.normalized());
      };
      shares[d].push_back(compare(own_cell.fine, other_cell.fine));
      shares[kSmearDirections + d].push_back(compare(own_cell.coarse, other_cell.coarse));
    }
  }
  double least = std::numeric_limits<double>::max();
  for (std::vector<double>& of_direction : shares) {
    if (of_direction.size() < kMinSharedCells) return std::nullopt;
    least = std::min(least, Median(std::move(of_direction)));
  }
  return least;
}

}  // namespace skyquilt::alignment
