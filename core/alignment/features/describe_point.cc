#include "core/alignment/features/describe_point.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/base/vector_clones.h"

namespace skyquilt::alignment {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Angle in turns, 0 to 1, to 1e-5 of a turn; 0 for (0, 0).
inline float Turns(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float ratio = std::min(ax, ay) / (std::max(ax, ay) + 1e-12F);
  const float s = ratio * ratio;
  // Abramowitz and Stegun 4.4.49.
  float angle =
      ratio * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + s * 0.0208351F))));
  angle = ay > ax ? 0.5F * kPi - angle : angle;
  angle = x < 0.0F ? kPi - angle : angle;
  angle = y < 0.0F ? 2.0F * kPi - angle : angle;
  return angle * (0.5F / kPi);
}

constexpr int kDirectionBins = 36;
constexpr float kDirectionBlurs = 1.5F;  // the window's sigma
constexpr float kNearlyAsStrong = 0.8F;
constexpr int kMaxRadius = 32;  // of the window: three sigmas of the coarsest blur in an octave, and more

constexpr std::size_t kMaxGradients = std::size_t{2 * kMaxRadius + 1} * (2 * kMaxRadius + 1);

// Of a window row by row, without a gap: what is made of them is made of all at once.
struct Gradients {
  std::array<float, kMaxGradients> x, y, magnitude;
  std::array<int, kMaxGradients> bin;
};

SKYQUILT_VECTOR_CLONES void FillGradients(const std::uint16_t* here, int width_px, int count,
                                          float* __restrict along, float* __restrict down) {
  for (int i = 0; i < count; ++i) {
    along[i] = static_cast<float>(static_cast<int>(here[i + 1]) - static_cast<int>(here[i - 1]));
    down[i] = static_cast<float>(static_cast<int>(here[i + width_px]) - static_cast<int>(here[i - width_px]));
  }
}

// Bare pointers: a bound that is checked keeps a loop from being vector instructions.
SKYQUILT_VECTOR_CLONES void FillBins(const float* x, const float* y, std::size_t count,
                                     float* __restrict magnitude, int* __restrict bin) {
  for (std::size_t i = 0; i < count; ++i) {
    magnitude[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    bin[i] = static_cast<int>(kDirectionBins * Turns(y[i], x[i]) + 0.5F);
  }
}

constexpr int kCells = 4, kAngles = 8;
constexpr float kCellBlurs = 3.0F;                   // side of a cell
constexpr int kSamplesACell = 4;                     // along a side
constexpr int kSide = kSamplesACell * (kCells + 1);  // half a cell more on each side fades out
constexpr int kSamples = kSide * kSide;

// What a sample of the grid gives to the cells, fixed once and for all.
struct GridSample {
  int first = 0;  // cell north-west of it, of the padded cells
  std::array<float, 4> weights{};
};

struct SampleGrid {
  std::array<float, kSamples> u{}, v{};  // in cells from the spot, along its direction and across
  std::array<GridSample, kSamples> samples{};
};

constexpr int kPadded = kCells + 2;

const SampleGrid& Grid() {
  static const SampleGrid grid = [] {
    SampleGrid made;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const std::size_t k = row * kSide + column;
        GridSample& sample = made.samples[k];
        const auto place = [](int step) {
          return (static_cast<float>(step) + 0.5F) / kSamplesACell - 0.5F * (kCells + 1);
        };
        made.u[k] = place(column), made.v[k] = place(row);
        // Counted from the centre of the padded first cell.
        const float u = made.u[k] + 0.5F * (kPadded - 1), v = made.v[k] + 0.5F * (kPadded - 1);
        const int left = static_cast<int>(u), top = static_cast<int>(v);
        const float fu = u - static_cast<float>(left), fv = v - static_cast<float>(top);
        sample.first = top * kPadded + left;
        const float near =
            std::exp(-(made.u[k] * made.u[k] + made.v[k] * made.v[k]) / (0.5F * kCells * kCells));
        sample.weights = {near * (1 - fu) * (1 - fv), near * fu * (1 - fv), near * (1 - fu) * fv,
                          near * fu * fv};
      }
    }
    return made;
  }();
  return grid;
}

struct SamplePlaces {
  std::array<int, kSamples> x, y;
};

// The pixels nearest to the grid's samples. True: all of them have neighbours on all sides.
SKYQUILT_VECTOR_CLONES bool FindSamples(const SampleGrid& grid, const ScalePoint& point, float cos_px,
                                        float sin_px, int width_px, int height_px, SamplePlaces& places) {
  int outside = 0;  // negative where one is
  for (std::size_t i = 0; i < kSamples; ++i) {
    const float u = grid.u[i], v = grid.v[i];
    const int x = static_cast<int>(std::floor(point.x_px + cos_px * u - sin_px * v + 0.5F));
    const int y = static_cast<int>(std::floor(point.y_px + sin_px * u + cos_px * v + 0.5F));
    places.x[i] = x, places.y[i] = y;
    outside |= (x - 1) | (y - 1) | (width_px - 2 - x) | (height_px - 2 - y);
  }
  return outside >= 0;
}

// Angles in their bins, counted from the direction.
SKYQUILT_VECTOR_CLONES void TurnGradients(const std::array<float, kSamples>& gx,
                                          const std::array<float, kSamples>& gy, float turned,
                                          std::array<float, kSamples>& magnitude,
                                          std::array<float, kSamples>& angle) {
  for (std::size_t i = 0; i < kSamples; ++i) {
    magnitude[i] = std::sqrt(gx[i] * gx[i] + gy[i] * gy[i]);
    const float turns = Turns(gy[i], gx[i]) - turned + 2.0F;
    angle[i] = kAngles * (turns - static_cast<float>(static_cast<int>(turns)));
  }
}

Descriptor Pack(std::array<float, 128>& bins) {
  float squares = 1e-12F;
  for (const float bin : bins) squares += bin * bin;
  // Glints and shadows must not outweigh all else.
  const float most = 0.2F * std::sqrt(squares);
  float sum = 1e-9F;
  for (float& bin : bins) bin = std::min(bin, most), sum += bin;
  Descriptor packed{};
  for (std::size_t k = 0; k < bins.size(); ++k)
    packed[k] = static_cast<std::uint8_t>(std::min(255.0F, 512.0F * std::sqrt(bins[k] / sum) + 0.5F));
  return packed;
}

}  // namespace

std::vector<float> DirectionsOf(const BlurredImage& layer, const ScalePoint& point) {
  const float sigma = kDirectionBlurs * point.blur_px;
  const int radius = std::min(kMaxRadius, static_cast<int>(std::lround(3.0F * sigma)));
  const int middle_x = static_cast<int>(std::lround(point.x_px)),
            middle_y = static_cast<int>(std::lround(point.y_px));
  std::array<float, kDirectionBins + 1> raw{};  // the last is the first again
  const float falloff = -0.5F / (sigma * sigma);
  std::vector<float> along_x(2 * radius + 1);
  for (int d = -radius; d <= radius; ++d) along_x[d + radius] = std::exp(falloff * static_cast<float>(d * d));
  const int west = std::max(-radius, 1 - middle_x), east = std::min(radius, layer.width_px - 2 - middle_x);
  const int north = std::max(-radius, 1 - middle_y), south = std::min(radius, layer.height_px - 2 - middle_y);
  const int across = std::max(0, east - west + 1), rows = std::max(0, south - north + 1);
  Gradients gradients;
  for (int row = 0; row < rows; ++row) {
    FillGradients(layer.Row(middle_y + north + row) + middle_x + west, layer.width_px, across,
                  gradients.x.data() + row * across, gradients.y.data() + row * across);
  }
  FillBins(gradients.x.data(), gradients.y.data(), rows * across, gradients.magnitude.data(),
           gradients.bin.data());
  std::size_t k = 0;
  for (int row = 0; row < rows; ++row) {
    const float along_y = along_x[north + row + radius];
    const float* along = along_x.data() + west + radius;
    for (int i = 0; i < across; ++i, ++k)
      raw[gradients.bin[k]] += along[i] * along_y * gradients.magnitude[k];
  }
  raw[0] += raw[kDirectionBins];
  std::array<float, kDirectionBins> smooth{};
  const auto at = [](int bin) { return static_cast<std::size_t>((bin + kDirectionBins) % kDirectionBins); };
  for (int bin = 0; bin < kDirectionBins; ++bin) {
    smooth[at(bin)] = (raw[at(bin - 2)] + raw[at(bin + 2)]) * (1.0F / 16.0F) +
                      (raw[at(bin - 1)] + raw[at(bin + 1)]) * (4.0F / 16.0F) + raw[at(bin)] * (6.0F / 16.0F);
  }
  const float most = *std::max_element(smooth.begin(), smooth.end());
  std::vector<std::pair<float, float>> peaks;  // height, direction
  for (int bin = 0; bin < kDirectionBins; ++bin) {
    const float left = smooth[at(bin - 1)], here = smooth[at(bin)], right = smooth[at(bin + 1)];
    if (here <= left || here <= right || here < kNearlyAsStrong * most) continue;
    const float between = static_cast<float>(bin) + 0.5F * (left - right) / (left - 2.0F * here + right);
    peaks.emplace_back(here, between * (2.0F * kPi / kDirectionBins));
  }
  std::sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::vector<float> directions;
  for (const auto& [height, direction] : peaks) directions.push_back(direction);
  return directions;
}

Descriptor Describe(const BlurredImage& layer, const ScalePoint& point, float direction_rad) {
  const SampleGrid& grid = Grid();
  const float cell_px = kCellBlurs * point.blur_px;
  const float cos_px = std::cos(direction_rad) * cell_px, sin_px = std::sin(direction_rad) * cell_px;
  SamplePlaces places;
  const bool is_inside = FindSamples(grid, point, cos_px, sin_px, layer.width_px, layer.height_px, places);
  std::array<float, kSamples> gx{}, gy{}, magnitude, angle;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const int x = places.x[i], y = places.y[i];
    if (!is_inside && (x < 1 || y < 1 || x + 1 >= layer.width_px || y + 1 >= layer.height_px)) continue;
    const std::uint16_t* here = layer.Row(y) + x;
    gx[i] = static_cast<float>(here[1] - here[-1]);
    gy[i] = static_cast<float>(here[layer.width_px] - here[-layer.width_px]);
  }
  TurnGradients(gx, gy, direction_rad * (0.5F / kPi), magnitude, angle);
  std::array<float, static_cast<std::size_t>(kPadded) * kPadded * kAngles> cells{};
  for (std::size_t i = 0; i < kSamples; ++i) {
    const int low = static_cast<int>(angle[i]);
    const float above = magnitude[i] * (angle[i] - static_cast<float>(low)), below = magnitude[i] - above;
    const std::size_t first_angle = low % kAngles, next_angle = (first_angle + 1) % kAngles;
    float* cell = cells.data() + static_cast<std::size_t>(grid.samples[i].first) * kAngles;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      float* bins = cell + (corner / 2 * kPadded + corner % 2) * kAngles;
      bins[first_angle] += grid.samples[i].weights[corner] * below;
      bins[next_angle] += grid.samples[i].weights[corner] * above;
    }
  }
  std::array<float, 128> inner{};
  for (std::size_t row = 0; row < kCells; ++row) {
    for (std::size_t column = 0; column < kCells; ++column)
      std::copy_n(cells.data() + ((row + 1) * kPadded + column + 1) * kAngles, kAngles,
                  inner.data() + (row * kCells + column) * kAngles);
  }
  return Pack(inner);
}

}  // namespace skyquilt::alignment
