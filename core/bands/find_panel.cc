#include "core/bands/find_panel.h"

#include <zbar.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/median.h"

namespace skyquilt::bands {
namespace {

bool AreDigits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

int NumberOf(std::string_view digits) {
  int number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

PanelCode::Point PointOf(std::string_view digits) {
  return {static_cast<double>(NumberOf(digits.substr(0, 4))),
          static_cast<double>(NumberOf(digits.substr(4, 3))) / 1000.0};
}

}  // namespace

std::optional<double> PanelCode::ReflectanceAt(double wavelength_nm) const {
  if (!reflectances) return std::nullopt;
  const auto& [low, high] = *reflectances;
  const double share = (wavelength_nm - low.wavelength_nm) / (high.wavelength_nm - low.wavelength_nm);
  return low.reflectance + std::clamp(share, 0.0, 1.0) * (high.reflectance - low.reflectance);
}

std::optional<PanelCode> ParsePanelCode(std::string_view text) {
  constexpr std::size_t kSerialLength = 15, kLineLength = 14;  // "RP04-1924106-OB", "04005250900524"
  if (text.size() < kSerialLength || !text.starts_with("RP") || text[4] != '-' || text[12] != '-' ||
      !AreDigits(text.substr(2, 2)) || !AreDigits(text.substr(5, 7))) {
    return std::nullopt;
  }
  PanelCode code{std::string(text.substr(0, kSerialLength)), NumberOf(text.substr(2, 2)), std::nullopt};
  const std::string_view line = text.substr(kSerialLength);
  if (line.size() != kLineLength || !AreDigits(line)) return code;
  const PanelCode::Point low = PointOf(line.substr(0, 7)), high = PointOf(line.substr(7, 7));
  if (low.wavelength_nm < high.wavelength_nm && low.reflectance > 0.0 && high.reflectance > 0.0)
    code.reflectances = {low, high};
  return code;
}

namespace {

using Eigen::Vector2d;

constexpr int kMinPicturePx = 64;
constexpr std::size_t kMinAreaPixels = 20;

// Eight bits, the darkest and brightest hundredth clipped: codes are read in black and white.
std::vector<std::uint8_t> StretchedOf(const image::SampleImage& picture) {
  std::vector<std::uint16_t> sorted;
  constexpr std::size_t kStep = 7;  // a sample is enough
  for (std::size_t i = 0; i < picture.samples.size(); i += kStep) sorted.push_back(picture.samples[i]);
  const auto at = [&](double share) {
    const auto place =
        sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), place, sorted.end());
    return static_cast<double>(*place);
  };
  const double dark = at(0.01), bright = std::max(at(0.99), dark + 1.0);
  std::vector<std::uint8_t> grey(picture.samples.size());
  std::transform(picture.samples.begin(), picture.samples.end(), grey.begin(), [&](std::uint16_t level) {
    return static_cast<std::uint8_t>(std::clamp(255.0 * (level - dark) / (bright - dark), 0.0, 255.0));
  });
  return grey;
}

struct Code {
  PanelCode code;
  PanelArea corners_px{};
};

std::optional<Code> ReadCode(const image::SampleImage& picture) {
  const std::vector<std::uint8_t> grey = StretchedOf(picture);
  zbar::ImageScanner scanner;
  scanner.set_config(zbar::ZBAR_NONE, zbar::ZBAR_CFG_ENABLE, 0);
  scanner.set_config(zbar::ZBAR_QRCODE, zbar::ZBAR_CFG_ENABLE, 1);
  zbar::Image image(static_cast<unsigned>(picture.width_px), static_cast<unsigned>(picture.height_px), "Y800",
                    grey.data(), grey.size());
  if (scanner.scan(image) <= 0) return std::nullopt;
  for (auto symbol = image.symbol_begin(); symbol != image.symbol_end(); ++symbol) {
    if (symbol->get_location_size() != 4) continue;
    auto code = ParsePanelCode(symbol->get_data());
    if (!code) continue;
    Code found{*std::move(code), {}};
    for (unsigned k = 0; k < 4; ++k)
      found.corners_px[k] = {symbol->get_location_x(k), symbol->get_location_y(k)};
    return found;
  }
  return std::nullopt;
}

// Calls `visit(index)` for each pixel of the picture whose centre lies within. False where the area reaches
// beyond the picture or is not convex.
template <typename Visit>
bool ForEachPixelIn(int width_px, int height_px, const PanelArea& area, const Visit& visit) {
  Vector2d low = area[0], high = area[0];
  for (const Vector2d& corner : area) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  if (!low.allFinite() || !high.allFinite() || low.minCoeff() < 0.0 || high.x() > width_px - 1 ||
      high.y() > height_px - 1) {
    return false;
  }
  const auto side = [&](std::size_t k, double x, double y) {
    const Vector2d along = area[(k + 1) % 4] - area[k];
    return along.x() * (y - area[k].y()) - along.y() * (x - area[k].x());
  };
  const Vector2d center = (area[0] + area[1] + area[2] + area[3]) / 4.0;
  std::array<double, 4> inward{};
  for (std::size_t k = 0; k < 4; ++k) inward[k] = side(k, center.x(), center.y());
  const bool is_convex =
      std::all_of(inward.begin(), inward.end(), [&](double s) { return s * inward[0] > 0.0; });
  if (!is_convex) return false;
  for (int y = static_cast<int>(std::ceil(low.y())); y <= high.y(); ++y) {
    for (int x = static_cast<int>(std::ceil(low.x())); x <= high.x(); ++x) {
      bool is_in = true;
      for (std::size_t k = 0; k < 4; ++k) is_in = is_in && side(k, x, y) * inward[0] >= 0.0;
      if (is_in)
        visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x));
    }
  }
  return true;
}

// Where the grey square stands: its centre so many sides of the code from the code's, half its side likewise.
// A little is left off at its rim.
struct SquarePlace {
  double away, half;
};
SquarePlace PlaceOf(int version) { return version < 3 ? SquarePlace{1.67, 0.58} : SquarePlace{1.55, 0.34}; }

}  // namespace

std::optional<AreaLevels> LevelsIn(const image::SampleImage& picture, const PanelArea& area_px) {
  std::vector<std::uint16_t> levels;
  const auto take = [&](std::size_t i) { levels.push_back(picture.samples[i]); };
  if (!ForEachPixelIn(picture.width_px, picture.height_px, area_px, take) || levels.size() < kMinAreaPixels)
    return std::nullopt;
  const auto clipped =
      std::count_if(levels.begin(), levels.end(), [](auto level) { return level >= kClippedLevel; });
  std::sort(levels.begin(), levels.end());
  const double median = levels[levels.size() / 2];
  const double half = levels[levels.size() * 3 / 4] - levels[levels.size() / 4];
  return AreaLevels{median, half / std::max(median, 1.0),
                    static_cast<double>(clipped) / static_cast<double>(levels.size())};
}

std::optional<double> MedianIn(const image::FloatImage& values, const PanelArea& area_px) {
  std::vector<float> held;
  const auto take = [&](std::size_t i) {
    if (!std::isnan(values.values[i])) held.push_back(values.values[i]);
  };
  if (!ForEachPixelIn(values.width_px, values.height_px, area_px, take) || held.size() < kMinAreaPixels)
    return std::nullopt;
  return Median(std::move(held));
}

std::optional<FoundPanel> FindPanel(const image::SampleImage& picture) {
  if (picture.width_px < kMinPicturePx || picture.height_px < kMinPicturePx) return std::nullopt;
  const std::optional<Code> code = ReadCode(picture);
  if (!code) return std::nullopt;
  const PanelArea& corners = code->corners_px;
  const Vector2d center = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
  const Vector2d along = (corners[1] - corners[0] + corners[2] - corners[3]) / 2.0;
  const Vector2d across = (corners[3] - corners[0] + corners[2] - corners[1]) / 2.0;
  const SquarePlace place = PlaceOf(code->code.version);
  std::optional<FoundPanel> best;
  double least_spread = std::numeric_limits<double>::infinity();
  for (const Vector2d& direction : {along, Vector2d(-along), across, Vector2d(-across)}) {
    const Vector2d middle = center + place.away * direction;
    const Vector2d u = place.half * along, v = place.half * across;
    const PanelArea area{Vector2d(middle - u - v), Vector2d(middle + u - v), Vector2d(middle + u + v),
                         Vector2d(middle - u + v)};
    const std::optional<AreaLevels> levels = LevelsIn(picture, area);
    if (!levels || levels->spread >= least_spread) continue;
    least_spread = levels->spread;
    best = FoundPanel{code->code, area};
  }
  return best;
}

}  // namespace skyquilt::bands
