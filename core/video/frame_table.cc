#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "core/flight/logs/log_builder.h"
#include "core/geo/lat_lon.h"
#include "core/video/take_frames.h"

namespace skyquilt::video {
namespace {

constexpr double kMaxGapS = 3.0;       // between samples, or from a sample to a frame before or after all
constexpr double kMaxSpanGapS = 20.0;  // subtitles that repeat a fix for seconds still say where it flew

// The samples around a moment and how far it is from the first to the second.
template <typename Sample>
struct Around {
  const Sample* before;
  const Sample* after;
  double share;
};

template <typename Sample>
std::optional<Around<Sample>> AroundMoment(const std::vector<Sample>& samples, double t_s) {
  if (samples.empty()) return std::nullopt;
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), t_s,
                       [](const Sample& sample, double moment) { return sample.t_s < moment; });
  if (after == samples.begin() || after == samples.end()) {
    const Sample& nearest = after == samples.begin() ? samples.front() : samples.back();
    if (std::abs(nearest.t_s - t_s) > kMaxGapS) return std::nullopt;
    return Around<Sample>{&nearest, &nearest, 0.0};
  }
  const Sample& before = *(after - 1);
  const double gap_s = after->t_s - before.t_s;
  if (gap_s > kMaxSpanGapS) return std::nullopt;
  return Around<Sample>{&before, &*after, gap_s > 0.0 ? (t_s - before.t_s) / gap_s : 0.0};
}

double Between(double a, double b, double share) { return a + share * (b - a); }

// Empty where one of the two is missing.
std::string Cell(const std::optional<double>& before, const std::optional<double>& after, double share) {
  return before && after ? fmt::format("{:.3f}", Between(*before, *after, share)) : std::string();
}

std::string PositionCells(const flight::FlightLog& log, double t_s) {
  const auto fix = AroundMoment(log.gnss, t_s);
  if (!fix) return ",,,,";
  const auto& [before, after, share] = *fix;
  const geo::LatLon position = geo::OnTheWay(before->position, after->position, share);
  return fmt::format("{:.9f},{:.9f},{},{},{}", position.lat_deg, position.lon_deg,
                     Cell(before->height_amsl_m, after->height_amsl_m, share),
                     Cell(before->height_ellipsoid_m, after->height_ellipsoid_m, share),
                     Cell(before->sigma_horizontal_m, after->sigma_horizontal_m, share));
}

std::string HeightCell(const flight::FlightLog& log, double t_s) {
  const auto height = AroundMoment(log.baro, t_s);
  if (!height) return "";
  return fmt::format("{:.3f}", Between(height->before->height_above_takeoff_m,
                                       height->after->height_above_takeoff_m, height->share));
}

std::string GimbalCells(const flight::FlightLog& log, double t_s) {
  const auto turned = AroundMoment(log.gimbal, t_s);
  if (!turned) return ",,";
  const Eigen::Vector3d angles_rad = flight::YawPitchRollFromNed(
      turned->before->ned_from_body.slerp(turned->share, turned->after->ned_from_body));
  const Eigen::Vector3d angles_deg = angles_rad * (180.0 / std::numbers::pi);
  return fmt::format("{:.3f},{:.3f},{:.3f}", angles_deg.x(), angles_deg.y(), angles_deg.z());
}

// A name with a comma or a quote in it, as CSV has it (RFC 4180).
std::string Quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

}  // namespace

std::string FrameTable(const std::vector<std::string>& names, const std::vector<double>& times_s,
                       const flight::FlightLog& log) {
  std::string text =
      "image,lat_deg,lon_deg,alt_msl_m,alt_ellipsoid_m,hacc_m,rel_alt_m,gimbal_yaw_deg,gimbal_pitch_deg,gimbal_roll_deg\n";
  bool says_anything = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string cells = fmt::format("{},{},{}", PositionCells(log, times_s[i]),
                                          HeightCell(log, times_s[i]), GimbalCells(log, times_s[i]));
    if (cells.find_first_not_of(',') == std::string::npos) continue;
    says_anything = true;
    text += Quoted(names[i]) + "," + cells + "\n";
  }
  return says_anything ? text : std::string();
}

}  // namespace skyquilt::video
