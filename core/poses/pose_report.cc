#include "core/poses/pose_report.h"

#include <nlohmann/json.hpp>

namespace skyquilt::poses {
namespace {

nlohmann::ordered_json OrNull(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::string PoseReportJson(const PoseReport& r) {
  const nlohmann::ordered_json json{{"method", r.method},
                                    {"is_placed", r.is_placed},
                                    {"logs", r.logs},
                                    {"series", r.series},
                                    {"time_match", r.time_match},
                                    {"time_offset_s", OrNull(r.time_offset_s)},
                                    {"time_sigma_s", OrNull(r.time_sigma_s)},
                                    {"camera_ahead_of_utc_s", OrNull(r.camera_ahead_of_utc_s)},
                                    {"convention", r.convention},
                                    {"height_rule", r.height_rule},
                                    {"photos_by_log", r.photos_by_log},
                                    {"photos_by_records", r.photos_by_records},
                                    {"knots", r.knots},
                                    {"iterations", r.iterations},
                                    {"median_error_radius_m", r.median_error_radius_m},
                                    {"largest_error_radius_m", r.largest_error_radius_m}};
  // File names come from file systems and need not be UTF-8.
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace skyquilt::poses
