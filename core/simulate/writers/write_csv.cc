#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/simulate/writers/write_logs.h"

namespace skyquilt::simulate {
namespace {

enum Column {
  kT,
  kUtc,
  kWx,
  kWy,
  kWz,
  kAx,
  kAy,
  kAz,
  kQw,
  kQx,
  kQy,
  kQz,
  kLat,
  kLon,
  kAltEll,
  kAltMsl,
  kVn,
  kVe,
  kVd,
  kSh,
  kSv,
  kFix,
  kBaro,
  kRange,
  kEvent,
  kColumns
};
constexpr const char* kHeader =
    "t,utc,wx,wy,wz,ax,ay,az,qw,qx,qy,qz,lat,lon,alt_ell,alt_msl,vn,ve,vd,sh,sv,fix,baro_alt,range,event\n";

using Row = std::array<std::string, kColumns>;

void PutVector(const Eigen::Vector3d& v, int first, const char* pattern, Row& row) {
  for (int i = 0; i < 3; ++i)
    row[static_cast<std::size_t>(first + i)] = fmt::format(fmt::runtime(pattern), v[i]);
}

struct Fill {
  Row& row;
  void operator()(const flight::ImuSample* s) const {
    PutVector(s->angular_rate_radps, kWx, "{:.7f}", row);
    PutVector(s->specific_force_mps2, kAx, "{:.6f}", row);
  }
  void operator()(const flight::AttitudeSample* s) const {
    const Eigen::Quaterniond& q = s->ned_from_body;
    row[kQw] = fmt::format("{:.8f}", q.w());
    row[kQx] = fmt::format("{:.8f}", q.x());
    row[kQy] = fmt::format("{:.8f}", q.y());
    row[kQz] = fmt::format("{:.8f}", q.z());
  }
  void operator()(const flight::GnssSample* s) const {
    row[kLat] = fmt::format("{:.10f}", s->position.lat_deg);
    row[kLon] = fmt::format("{:.10f}", s->position.lon_deg);
    if (s->height_ellipsoid_m) row[kAltEll] = fmt::format("{:.4f}", *s->height_ellipsoid_m);
    if (s->height_amsl_m && !s->height_ellipsoid_m) row[kAltMsl] = fmt::format("{:.4f}", *s->height_amsl_m);
    if (s->velocity_in_ned_mps) PutVector(*s->velocity_in_ned_mps, kVn, "{:.4f}", row);
    if (s->sigma_horizontal_m) row[kSh] = fmt::format("{:.4f}", *s->sigma_horizontal_m);
    if (s->sigma_vertical_m) row[kSv] = fmt::format("{:.4f}", *s->sigma_vertical_m);
    row[kFix] = fmt::format("{}", s->is_rtk_fixed ? 6 : 3);
  }
  void operator()(const flight::BaroSample* s) const {
    row[kBaro] = fmt::format("{:.4f}", s->height_above_takeoff_m);
  }
  void operator()(const flight::RangeSample* s) const { row[kRange] = fmt::format("{:.4f}", s->distance_m); }
  void operator()(const flight::CameraEvent* s) const {
    row[kEvent] = s->image_name ? *s->image_name : fmt::format("{}", s->sequence.value_or(0));
  }
};

}  // namespace

std::string FlightCsv(const flight::FlightLog& log) {
  std::string text = kHeader;
  for (const LogRecord& record : RecordsInTime(log)) {
    Row row;
    const double t_s = TimeOf(record);
    row[kT] = fmt::format("{:.6f}", t_s);
    if (log.utc_at_zero) {
      const auto utc = *log.utc_at_zero + std::chrono::microseconds(std::llround(t_s * 1e6));
      const auto seconds = std::chrono::floor<std::chrono::seconds>(utc);
      row[kUtc] =
          fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:06}Z",
                      fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)), (utc - seconds).count());
    }
    std::visit(Fill{row}, record);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      text += row[i];
    }
    text += '\n';
  }
  return text;
}

}  // namespace skyquilt::simulate
