#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/simulate/writers/write_logs.h"

namespace skyquilt::simulate {
namespace {

constexpr auto kColumns = std::to_array<std::string_view>(
    {"t",   "utc",     "wx",      "wy", "wz", "ax", "ay", "az", "qw",  "qx",       "qy",    "qz",   "lat",
     "lon", "alt_ell", "alt_msl", "vn", "ve", "vd", "sh", "sv", "fix", "baro_alt", "range", "event"});

// By column.
using Row = std::map<std::string_view, std::string>;

void PutVector(const Eigen::Vector3d& v, const std::array<std::string_view, 3>& columns, const char* pattern,
               Row& row) {
  for (int i = 0; i < 3; ++i)
    row[columns[static_cast<std::size_t>(i)]] = fmt::format(fmt::runtime(pattern), v[i]);
}

struct Fill {
  Row& row;
  void operator()(const flight::ImuSample* s) const {
    PutVector(s->angular_rate_radps, {"wx", "wy", "wz"}, "{:.7f}", row);
    PutVector(s->specific_force_mps2, {"ax", "ay", "az"}, "{:.6f}", row);
  }
  void operator()(const flight::AttitudeSample* s) const {
    const Eigen::Quaterniond& q = s->ned_from_body;
    row["qw"] = fmt::format("{:.8f}", q.w());
    row["qx"] = fmt::format("{:.8f}", q.x());
    row["qy"] = fmt::format("{:.8f}", q.y());
    row["qz"] = fmt::format("{:.8f}", q.z());
  }
  void operator()(const flight::GnssSample* s) const {
    row["lat"] = fmt::format("{:.10f}", s->position.lat_deg);
    row["lon"] = fmt::format("{:.10f}", s->position.lon_deg);
    if (s->height_ellipsoid_m) row["alt_ell"] = fmt::format("{:.4f}", *s->height_ellipsoid_m);
    if (s->height_amsl_m && !s->height_ellipsoid_m) row["alt_msl"] = fmt::format("{:.4f}", *s->height_amsl_m);
    if (s->velocity_in_ned_mps) PutVector(*s->velocity_in_ned_mps, {"vn", "ve", "vd"}, "{:.4f}", row);
    if (s->sigma_horizontal_m) row["sh"] = fmt::format("{:.4f}", *s->sigma_horizontal_m);
    if (s->sigma_vertical_m) row["sv"] = fmt::format("{:.4f}", *s->sigma_vertical_m);
    row["fix"] = fmt::format("{}", s->is_rtk_fixed ? 6 : 3);
  }
  void operator()(const flight::BaroSample* s) const {
    row["baro_alt"] = fmt::format("{:.4f}", s->height_above_takeoff_m);
  }
  void operator()(const flight::RangeSample* s) const { row["range"] = fmt::format("{:.4f}", s->distance_m); }
  void operator()(const flight::CameraEvent* s) const {
    row["event"] = s->image_name ? *s->image_name : fmt::format("{}", s->sequence.value_or(0));
  }
};

}  // namespace

std::string FlightCsv(const flight::FlightLog& log) {
  std::string text = fmt::format("{}\n", fmt::join(kColumns, ","));
  for (const LogRecord& record : RecordsInTime(log)) {
    Row row;
    const double t_s = TimeOf(record);
    row["t"] = fmt::format("{:.6f}", t_s);
    if (log.utc_at_zero) {
      const auto utc = *log.utc_at_zero + std::chrono::microseconds(std::llround(t_s * 1e6));
      const auto seconds = std::chrono::floor<std::chrono::seconds>(utc);
      row["utc"] =
          fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:06}Z",
                      fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)), (utc - seconds).count());
    }
    std::visit(Fill{row}, record);
    std::vector<std::string> cells;
    for (const std::string_view column : kColumns) cells.push_back(row[column]);
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

}  // namespace skyquilt::simulate
