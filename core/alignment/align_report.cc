#include "core/alignment/align_report.h"

#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/camera/lens_fields.h"

namespace skyquilt::alignment {
namespace {

using Json = nlohmann::ordered_json;

Json PairJson(const AlignPairReport& pair) {
  return {{"first", pair.first}, {"second", pair.second}, {"matches", pair.matches}, {"rms_m", pair.rms_m}};
}

Json LensJson(const camera::Intrinsics& lens) {
  Json json;
  camera::VisitLensFields(lens, [&](const char* name, auto value) { json[name] = value; });
  return json;
}

}  // namespace

std::string_view FaultName(PhotoFault fault) {
  switch (fault) {
    case PhotoFault::kPositionWrong:
      return "position_wrong";
    case PhotoFault::kYawWrong:
      return "yaw_wrong";
    case PhotoFault::kStoredTurned:
      return "stored_turned";
    case PhotoFault::kCopy:
      return "copy";
    case PhotoFault::kBlurred:
      return "blurred";
    case PhotoFault::kOtherPlace:
      return "other_place";
    case PhotoFault::kFarAway:
      return "far_away";
  }
  SKYQUILT_CHECK(false, "every fault has a name");
  return {};
}

std::string AlignReportJson(const AlignReport& report) {
  Json json = {{"photos", report.photos},
               {"aligned", report.aligned},
               {"pieces", report.components},
               {"pairs_tried", report.pairs_tried},
               {"pairs_linked", report.pairs_linked},
               {"pairs_rejected", report.pairs_rejected},
               {"pairs_by_direct", report.pairs_by_direct},
               {"tie_points", report.tie_points},
               {"observations", report.observations},
               {"observations_dropped", report.observations_dropped},
               {"residual_rms_px", report.residual_rms_px},
               {"position_residual_m", report.position_residual_m},
               {"attitude_residual_deg", report.attitude_residual_deg},
               {"solver", report.solver},
               {"iterations", report.iterations},
               {"corrections", report.corrections}};
  for (const GyroReport& gyro : report.gyros) {
    json["gyros"].push_back({{"camera_key", gyro.camera_key},
                             {"pairs", gyro.pairs},
                             {"matches", gyro.matches},
                             {"fitting", gyro.fitting},
                             {"fitting_without", gyro.fitting_without},
                             {"lag_s", gyro.lag_s},
                             {"is_used", gyro.is_used}});
  }
  json["timings_s"] = {{"decode", report.decode_s},
                       {"features", report.features_s},
                       {"matching_wall", report.matching_s},
                       {"adjustment_wall", report.adjustment_s},
                       {"total_wall", report.total_s}};
  json["cameras"] = Json::array();
  for (const AlignLensReport& lens : report.lenses) {
    json["cameras"].push_back({{"camera_key", lens.camera_key},
                               {"recorded", LensJson(lens.recorded)},
                               {"adjusted", LensJson(lens.adjusted)},
                               {"sigma_focal_px", lens.sigma_focal_px},
                               {"focal_is_held", lens.focal_is_held}});
  }
  json["photo_reports"] = Json::array();
  for (const AlignPhotoReport& photo : report.photo_reports) {
    json["photo_reports"].push_back({{"name", photo.name},
                                     {"placement", PlacementName(photo.placement)},
                                     {"reason", photo.reason},
                                     {"features", photo.features},
                                     {"links", photo.links},
                                     {"observations", photo.observations},
                                     {"residual_rms_px", photo.residual_rms_px},
                                     {"moved_m", photo.moved_m},
                                     {"turned_deg", photo.turned_deg},
                                     {"error_radius_m", photo.error_radius_m},
                                     {"placed_by", photo.is_by_images ? "images" : "records"},
                                     {"faults", Json::array()}});
    for (const PhotoFault fault : photo.faults) {
      json["photo_reports"].back()["faults"].push_back(FaultName(fault));
    }
  }
  json["pairs"] = Json::array();
  for (const AlignPairReport& pair : report.pairs) {
    Json told = PairJson(pair);
    told["rms_px"] = pair.rms_px;
    told["by_direct"] = pair.is_by_direct;
    json["pairs"].push_back(std::move(told));
  }
  json["rejected_pairs"] = Json::array();
  for (const AlignPairReport& pair : report.rejected_pairs) {
    json["rejected_pairs"].push_back(PairJson(pair));
  }
  json["ground_control"] = Json::array();
  for (const ControlReport& point : report.control) {
    json["ground_control"].push_back({{"name", point.name},
                                      {"sightings", point.sightings},
                                      {"is_used", point.is_used},
                                      {"reason", point.reason},
                                      {"miss_east_m", point.miss_east_m},
                                      {"miss_north_m", point.miss_north_m},
                                      {"miss_up_m", point.miss_up_m},
                                      {"residual_px", point.residual_px}});
  }
  json["position_bias_m"] = {report.position_bias_m.x(), report.position_bias_m.y(),
                             report.position_bias_m.z()};
  const SecondLegReport& second = report.second_leg;
  json["placed_by"] = second.is_taken ? "images" : "records";
  json["second_leg"] = {{"why", second.why},
                        {"outcome", second.outcome},
                        {"is_taken", second.is_taken},
                        {"registered", second.registered},
                        {"groups", second.groups},
                        {"pairs_compared", second.pairs_compared},
                        {"pairs_verified", second.pairs_verified},
                        {"pairs_refused", second.pairs_refused},
                        {"residual_rms_px", second.residual_rms_px},
                        {"total_wall_s", second.total_s}};
  // Names are the user's: bytes that are not UTF-8 are replaced, never refused.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace skyquilt::alignment
