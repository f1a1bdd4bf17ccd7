#include "core/bands/panels/panel_code.h"

#include <algorithm>
#include <charconv>
#include <utility>

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

}  // namespace skyquilt::bands
