#include "core/bands/panels/scale_band.h"

#include <algorithm>

#include "core/bands/band_name.h"
#include "core/base/check.h"

namespace skyquilt::bands {

double ScaleBand(Captures& captures, const std::string& band, std::vector<double> factors, HeldAgainst by,
                 const std::string& method, std::vector<flight::Remark>& warnings) {
  SKYQUILT_CHECK(!factors.empty(), "a band is scaled by what somebody says");
  std::sort(factors.begin(), factors.end());
  const double factor = (factors[(factors.size() - 1) / 2] + factors[factors.size() / 2]) / 2.0;
  constexpr double kDoubtedSpread = 0.1;
  const double apart = (factors.back() - factors.front()) / factor;
  if (apart > kDoubtedSpread) {
    warnings.push_back(
        {by == HeldAgainst::kPanel ? flight::RemarkCode::kPanelsApart : flight::RemarkCode::kTargetsApart,
         {{"band", band}, {"apart_percent", 100.0 * apart}}});
  }
  for (Capture& capture : captures.captures) {
    for (BandPhoto& photo : capture.photos) {
      if (photo.facts.name != band) continue;
      photo.facts.radiometry.per_level *= factor;
      photo.facts.radiometry.calibration = Calibration::kReflectance;
    }
  }
  for (Band& one : captures.bands) {
    if (one.name != band) continue;
    one.calibration = Calibration::kReflectance;
    one.method += (one.method.empty() ? "" : ", ") + method;
    one.held_against = by;
  }
  return factor;
}

std::optional<double> ReflectanceOf(const flight::KnownReflectance& known, const std::string& band) {
  for (const auto& [name, share] : known.bands) {
    if (BandNameOf(name) == band) return share;
  }
  return known.all;
}

}  // namespace skyquilt::bands
