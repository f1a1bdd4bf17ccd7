#include "core/flight/metadata/attitude_tags.h"

#include <cmath>
#include <string_view>

#include "core/flight/bytes/text_fields.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

struct Degrees {
  std::optional<double> yaw, pitch, roll;
  bool any() const { return yaw || pitch || roll; }
};

Degrees FromXmp(const XmpTags& xmp, std::string_view yaw, std::string_view pitch, std::string_view roll) {
  return {xmp.Number(yaw), xmp.Number(pitch), xmp.Number(roll)};
}

// A set of angles is usable with yaw and pitch, within a turn, and not the zeros of a device that never knew.
bool IsUsable(const Degrees& angles, std::string_view source, std::vector<Remark>& notes) {
  if (!angles.yaw || !angles.pitch) return false;
  const double roll = angles.roll.value_or(0.0);
  if (std::abs(*angles.yaw) > 720.0 || std::abs(*angles.pitch) > 360.0 || std::abs(roll) > 360.0) {
    notes.push_back({RemarkCode::kAnglesImpossible, {{"tags", std::string(source)}}});
    return false;
  }
  if (*angles.yaw == 0.0 && *angles.pitch == 0.0) {
    notes.push_back({RemarkCode::kAnglesZero, {{"tags", std::string(source)}}});
    return false;
  }
  return true;
}

RecordedAttitude Attitude(AttitudeKind kind, const Degrees& angles, std::string_view source) {
  RecordedAttitude attitude;
  attitude.kind = kind;
  attitude.yaw_rad = geo::WrapRad(geo::DegToRad(*angles.yaw));
  attitude.pitch_rad = geo::DegToRad(*angles.pitch);
  attitude.roll_rad = geo::WrapRad(geo::DegToRad(angles.roll.value_or(0.0)));
  attitude.source = source;
  return attitude;
}

// Past the vertical some gimbals report roll = +-180. (yaw, pitch, roll) and (yaw + 180, -180 - pitch, roll -
// 180) are the same rotation; the second form has an upright camera and keeps yaw meaningful.
RecordedAttitude Gimbal(const Degrees& angles, std::string_view source) {
  RecordedAttitude attitude = Attitude(AttitudeKind::kGimbal, angles, source);
  if (std::abs(attitude.roll_rad) > 0.5 * geo::kPi) {
    attitude.yaw_rad = geo::WrapRad(attitude.yaw_rad + geo::kPi);
    attitude.pitch_rad = (attitude.pitch_rad > 0.0 ? geo::kPi : -geo::kPi) - attitude.pitch_rad;
    attitude.roll_rad = geo::WrapRad(attitude.roll_rad - geo::kPi);
  }
  return attitude;
}

bool IsAutel(const std::string& make) { return LowerCase(make).find("autel") != std::string::npos; }

std::optional<double> Sum(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return std::nullopt;
  return *a + *b;
}

std::optional<RecordedAttitude> HeadingOnly(std::optional<double> yaw_deg, std::string_view source,
                                            std::vector<Remark>& notes) {
  if (!yaw_deg || *yaw_deg == 0.0 || std::abs(*yaw_deg) > 720.0) return std::nullopt;
  notes.push_back(RemarkCode::kHeadingAlone);
  return Attitude(AttitudeKind::kAirframe, {yaw_deg, 0.0, 0.0}, source);
}

}  // namespace

std::optional<RecordedAttitude> AttitudeFromTags(const XmpTags& xmp,
                                                 const std::optional<DjiMakerNote>& maker_note,
                                                 const std::string& make, std::vector<Remark>& notes) {
  const Degrees dji =
      FromXmp(xmp, "drone-dji:GimbalYawDegree", "drone-dji:GimbalPitchDegree", "drone-dji:GimbalRollDegree");
  if (IsUsable(dji, "drone-dji", notes)) return Gimbal(dji, "drone-dji");
  if (maker_note && !dji.any()) {
    const Degrees note{maker_note->camera_yaw_deg, maker_note->camera_pitch_deg, maker_note->camera_roll_deg};
    if (IsUsable(note, "DJI maker note", notes)) return Gimbal(note, "DJI maker note");
  }
  const Degrees parrot = FromXmp(xmp, "drone-parrot:CameraYawDegree", "drone-parrot:CameraPitchDegree",
                                 "drone-parrot:CameraRollDegree");
  if (IsUsable(parrot, "drone-parrot", notes)) return Gimbal(parrot, "drone-parrot");
  const std::string skydio_struct = "drone-skydio:CameraOrientationNED/drone-skydio:";
  const Degrees skydio = FromXmp(xmp, skydio_struct + "Yaw", skydio_struct + "Pitch", skydio_struct + "Roll");
  if (IsUsable(skydio, "drone-skydio", notes)) return Gimbal(skydio, "drone-skydio");
  const Degrees teal{Sum(xmp.Number("exif:PlatformYaw"), xmp.Number("exif:CameraYaw")),
                     Sum(xmp.Number("exif:PlatformPitch"), xmp.Number("exif:CameraPitch")),
                     Sum(xmp.Number("exif:PlatformRoll"), xmp.Number("exif:CameraRoll"))};
  if (IsUsable(teal, "Teal", notes)) return Gimbal(teal, "Teal");

  Degrees camera = FromXmp(xmp, "Camera:Yaw", "Camera:Pitch", "Camera:Roll");
  if (IsUsable(camera, "Camera", notes)) {
    if (!IsAutel(make)) return Attitude(AttitudeKind::kAirframe, camera, "Camera");
    *camera.pitch -= 90.0;
    return Gimbal(camera, "Camera");
  }
  Degrees sensefly = FromXmp(xmp, "sensefly:Heading", "sensefly:PitchAngle", "sensefly:RollAngle");
  if (!sensefly.any()) sensefly = FromXmp(xmp, "sensefly:Yaw", "sensefly:Pitch", "sensefly:Roll");
  if (IsUsable(sensefly, "sensefly", notes)) return Attitude(AttitudeKind::kAirframe, sensefly, "sensefly");

  if (auto heading = HeadingOnly(xmp.Number("drone-dji:FlightYawDegree"), "drone-dji flight", notes)) {
    return heading;
  }
  if (auto heading = HeadingOnly(xmp.Number("drone-parrot:DroneYawDegree"), "drone-parrot flight", notes)) {
    return heading;
  }
  if (maker_note) return HeadingOnly(maker_note->yaw_deg, "DJI maker note flight", notes);
  return std::nullopt;
}

std::optional<RecordedVelocity> VelocityFromTags(const XmpTags& xmp) {
  constexpr double kFastest = 200.0;
  const auto checked = [](double east, double north, double up) -> std::optional<RecordedVelocity> {
    // All zero is what devices write that do not know.
    if (east == 0.0 && north == 0.0 && up == 0.0) return std::nullopt;
    if (std::hypot(east, north, up) > kFastest) return std::nullopt;
    return RecordedVelocity{east, north, up};
  };
  const auto x = xmp.Number("drone-dji:FlightXSpeed");
  const auto y = xmp.Number("drone-dji:FlightYSpeed");
  const auto z = xmp.Number("drone-dji:FlightZSpeed");
  if (x && y && z) return checked(*y, *x, *z == 0.0 ? 0.0 : -*z);
  const auto parts = ParseXmpNumbers(xmp.Text("Camera:IMULinearVelocity"));
  if (parts.size() > 2 && parts[0] && parts[1] && parts[2]) return checked(*parts[0], *parts[1], *parts[2]);
  return std::nullopt;
}

}  // namespace skyquilt::flight
