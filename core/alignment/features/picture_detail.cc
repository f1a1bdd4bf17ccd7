#include "core/alignment/features/picture_detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {
namespace {

constexpr double kCoarser = 4.0;
constexpr int kDirections = 36;
constexpr double kSmoothedPx = 1.0;
constexpr double kShareOfCells = 0.75;

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

}  // namespace

double EnergyAlong(const DirectedEnergy& energy, double c, double s) {
  return energy[0] * c * c * c * c + energy[1] * c * c * c * s + energy[2] * c * c * s * s +
         energy[3] * c * s * s * s + energy[4] * s * s * s * s;
}

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
      detail.cells.push_back({fine.In(column, row), coarse.In(column, row),
                              static_cast<float>(cv::mean(picture(CellOf(picture, column, row)))[0])});
    }
  }
  return detail;
}

// Of the cells that are sharper than most: water and asphalt have no detail, but hardly fill a picture; a
// blurred one is sharp nowhere.
double SharpnessByItself(const PictureDetail& detail) {
  if (detail.cells.empty()) return 0.0;
  std::vector<std::pair<double, double>> cells;  // coarse detail, sharpness
  for (const DetailCell& cell : detail.cells) {
    const double coarse = Extremes(cell.coarse).second + kMinDetail;
    cells.emplace_back(coarse, Extremes(cell.fine).first / coarse);
  }
  std::sort(cells.begin(), cells.end());
  std::vector<double> sharpness;
  for (std::size_t k = cells.size() / 2; k < cells.size(); ++k) sharpness.push_back(cells[k].second);
  return Percentile(std::move(sharpness), kShareOfCells);
}

}  // namespace skyquilt::alignment
