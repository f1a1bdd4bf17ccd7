#include "core/flight/metadata/attitude_tags.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/bytes/text_fields.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {
namespace {

std::optional<DjiMakerNote> ReadInOrder(std::span<const std::uint8_t> note, bool is_big_endian) {
  constexpr std::uint32_t kMaxEntries = 100;
  constexpr std::uint32_t kFloat = 11;
  if (note.size() < 2) return std::nullopt;
  const std::uint64_t count = UnsignedAt(note.data(), 2, is_big_endian);
  if (count == 0 || count > kMaxEntries || note.size() < 2 + 12 * std::size_t{count}) return std::nullopt;
  DjiMakerNote found;
  std::optional<double>* const fields[] = {&found.pitch_deg,      &found.yaw_deg,
                                           &found.roll_deg,       &found.camera_pitch_deg,
                                           &found.camera_yaw_deg, &found.camera_roll_deg};
  constexpr std::uint32_t kFirstTag = 6;
  bool any = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint8_t* entry = note.data() + 2 + 12 * std::size_t{i};
    const std::uint64_t tag = UnsignedAt(entry, 2, is_big_endian);
    if (tag < kFirstTag || tag >= kFirstTag + std::size(fields)) continue;
    if (UnsignedAt(entry + 2, 2, is_big_endian) != kFloat || UnsignedAt(entry + 4, 4, is_big_endian) != 1)
      continue;
    const float value =
        std::bit_cast<float>(static_cast<std::uint32_t>(UnsignedAt(entry + 8, 4, is_big_endian)));
    if (!std::isfinite(value) || std::abs(value) > 1000.0f) continue;
    *fields[tag - kFirstTag] = static_cast<double>(value);
    any = true;
  }
  if (!any) return std::nullopt;
  return found;
}

}  // namespace

std::optional<DjiMakerNote> ReadDjiMakerNote(std::span<const std::uint8_t> note, bool exif_is_big_endian) {
  // Read the wrong way round, the number of entries or the type of each is nonsense: one order fits at most.
  if (auto found = ReadInOrder(note, exif_is_big_endian)) return found;
  return ReadInOrder(note, !exif_is_big_endian);
}

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

// From nadir this would be a look backwards, 60 degrees up from straight down, which no survey's camera
// takes: such a pitch counts from the horizon, as some firmware writes it in the other's names.
constexpr double kFarthestBackDeg = -60.0;
// Autel's gimbals stop straight down.
constexpr double kFarthestBackOfAutelDeg = -10.0;

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
  const Degrees yuneec =
      FromXmp(xmp, "drone-yuneec:GimbalYaw", "drone-yuneec:GimbalPitch", "drone-yuneec:GimbalRoll");
  if (IsUsable(yuneec, "drone-yuneec", notes)) return Gimbal(yuneec, "drone-yuneec");
  const Degrees cgo3 = FromXmp(xmp, "xmp:CameraYaw", "xmp:CameraPitch", "xmp:CameraRoll");
  if (IsUsable(cgo3, "Yuneec CGO3", notes)) return Gimbal(cgo3, "Yuneec CGO3");
  const Degrees teal{Sum(xmp.Number("exif:PlatformYaw"), xmp.Number("exif:CameraYaw")),
                     Sum(xmp.Number("exif:PlatformPitch"), xmp.Number("exif:CameraPitch")),
                     Sum(xmp.Number("exif:PlatformRoll"), xmp.Number("exif:CameraRoll"))};
  if (IsUsable(teal, "Teal", notes)) return Gimbal(teal, "Teal");

  Degrees camera = FromXmp(xmp, "Camera:Yaw", "Camera:Pitch", "Camera:Roll");
  if (IsUsable(camera, "Camera", notes)) {
    if (*camera.pitch < (IsAutel(make) ? kFarthestBackOfAutelDeg : kFarthestBackDeg))
      return Gimbal(camera, "Camera");
    if (!IsAutel(make)) return Attitude(AttitudeKind::kAirframe, camera, "Camera");
    *camera.pitch -= 90.0;
    return Gimbal(camera, "Camera");
  }
  const Degrees phase_one =
      FromXmp(xmp, "aerialgps:GPSIMUYaw", "aerialgps:GPSIMUPitch", "aerialgps:GPSIMURoll");
  if (IsUsable(phase_one, "aerialgps", notes)) return Gimbal(phase_one, "aerialgps");
  Degrees sensefly = FromXmp(xmp, "sensefly:Heading", "sensefly:PitchAngle", "sensefly:RollAngle");
  if (!sensefly.any()) sensefly = FromXmp(xmp, "sensefly:Yaw", "sensefly:Pitch", "sensefly:Roll");
  if (IsUsable(sensefly, "sensefly", notes)) return Attitude(AttitudeKind::kAirframe, sensefly, "sensefly");

  constexpr std::pair<std::string_view, std::string_view> kHeadings[] = {
      {"drone-dji:FlightYawDegree", "drone-dji flight"},
      {"drone-parrot:DroneYawDegree", "drone-parrot flight"},
      {"drone-yuneec:DroneYaw", "drone-yuneec flight"}};
  for (const auto& [name, source] : kHeadings) {
    if (auto heading = HeadingOnly(xmp.Number(name), source, notes)) return heading;
  }
  if (maker_note) return HeadingOnly(maker_note->yaw_deg, "DJI maker note flight", notes);
  return std::nullopt;
}

std::optional<RecordedDirection> DirectionFromTags(const ExifRecord& exif) {
  if (!exif.image_direction_deg || *exif.image_direction_deg == 0.0) return std::nullopt;
  // By orientation, 1 to 8: how far clockwise of the shown picture's top that of the stored one is.
  constexpr std::array<double, 9> kTopDeg = {0.0, 0.0, 0.0, 180.0, 180.0, 270.0, 90.0, 90.0, 270.0};
  const double top_deg = kTopDeg[static_cast<std::size_t>(exif.orientation.value_or(1))];
  return RecordedDirection{geo::WrapRad(geo::DegToRad(*exif.image_direction_deg + top_deg)),
                           exif.is_direction_from_true_north};
}

std::optional<Eigen::Vector3d> VelocityFromTags(const XmpTags& xmp) {
  constexpr double kFastestMps = 200.0;
  const auto checked = [](const Eigen::Vector3d& in_enu_mps) -> std::optional<Eigen::Vector3d> {
    // All zero is what devices write that do not know.
    if (in_enu_mps.isZero(0.0) || in_enu_mps.norm() > kFastestMps) return std::nullopt;
    return in_enu_mps;
  };
  const auto x = xmp.Number("drone-dji:FlightXSpeed");
  const auto y = xmp.Number("drone-dji:FlightYSpeed");
  const auto z = xmp.Number("drone-dji:FlightZSpeed");
  if (x && y && z) return checked({*y, *x, *z == 0.0 ? 0.0 : -*z});
  const auto parts = ParseXmpNumbers(xmp.Text("Camera:IMULinearVelocity"));
  if (parts.size() > 2 && parts[0] && parts[1] && parts[2]) return checked({*parts[0], *parts[1], *parts[2]});
  return std::nullopt;
}

namespace {

constexpr std::size_t kRecordBytes = 24;
constexpr std::size_t kMaxRecords = 4096;
constexpr double kFastestRadps = 35.0;  // the range of the gyros in cameras: 2000 degrees per second
constexpr double kLongestGapS = 0.02;   // between records: no shaking may be missed
constexpr double kMaxOffsetS = 1.0;     // from the first record to the first row

// The gyro's axes are the body's (x ahead, y right, z down) of a camera that looks down with its image top
// ahead, as its angles are recorded too.
Eigen::Vector3d InCam(const Eigen::Vector3d& in_body) { return {in_body.y(), -in_body.x(), in_body.z()}; }

}  // namespace

std::optional<RecordedTurning> TurningFromTags(const XmpTags& xmp, std::vector<Remark>& notes) {
  const std::string* text = xmp.Find("Camera:IMUAngularVelocity");
  if (text == nullptr || text->empty()) return std::nullopt;
  const auto refuse = [&](RemarkCode why) -> std::optional<RecordedTurning> {
    notes.push_back({RemarkCode::kGyroNotUsed, {{"why", Remark(why)}}});
    return std::nullopt;
  };
  const auto offset_ns = xmp.Number("Camera:IMUTimeOffset");
  const double offset_s = 1e-9 * offset_ns.value_or(0.0);
  const bool is_odd = !offset_ns && xmp.Find("Camera:IMUTimeOffset") != nullptr;
  if (is_odd || std::abs(offset_s) > kMaxOffsetS) return refuse(RemarkCode::kGyroAtImpossibleTime);
  const auto bytes = FromBase64(*text, kRecordBytes * kMaxRecords);
  if (!bytes || bytes->size() % kRecordBytes != 0) return refuse(RemarkCode::kGyroDamaged);
  if (bytes->size() < 2 * kRecordBytes) return refuse(RemarkCode::kGyroTooShort);
  RecordedTurning turning;
  const auto first_us = LoadLittle<std::uint64_t>(bytes->data());
  for (std::size_t at = 0; at < bytes->size(); at += kRecordBytes) {
    const std::uint8_t* record = bytes->data() + at;
    const auto us = LoadLittle<std::uint64_t>(record);
    Eigen::Vector3d in_body;
    for (int axis = 0; axis < 3; ++axis)
      in_body[axis] = LoadLittle<float>(record + 8 + std::ptrdiff_t{4} * axis);
    // Compared so that no NaN passes.
    if (!(in_body.cwiseAbs().maxCoeff() <= kFastestRadps) || !in_body.allFinite())
      return refuse(RemarkCode::kGyroImpossibleRates);
    if (us < first_us) return refuse(RemarkCode::kGyroBackwards);
    const double time_s = 1e-6 * static_cast<double>(us - first_us) - offset_s;
    if (!turning.samples.empty()) {
      const double step_s = time_s - turning.samples.back().time_s;
      if (!(step_s > 0.0)) return refuse(RemarkCode::kGyroBackwards);
      if (step_s > kLongestGapS) return refuse(RemarkCode::kGyroWithGaps);
    }
    turning.samples.push_back({time_s, InCam(in_body)});
  }
  return turning;
}

}  // namespace skyquilt::flight
