// How a camera was held, moved and turned, by its tags. The makers' conventions for recorded angles, brought
// to ours (photo.h: yaw clockwise from true north, pitch 0 = horizon for the camera, intrinsic Z-Y-X in NED).
// In the order tried:
//   DJI, Hasselblad, Autel (new)  drone-dji:Gimbal*Degree          camera, horizon zero       -> kGimbal
//   DJI maker note                CameraPitch/Yaw/Roll             camera, horizon zero       -> kGimbal
//   Parrot ANAFI                  drone-parrot:Camera*Degree       camera, horizon zero       -> kGimbal
//   Skydio                        drone-skydio:CameraOrientationNED camera, horizon zero      -> kGimbal
//   Yuneec (E90, C23)             drone-yuneec:Gimbal*              camera, horizon zero      -> kGimbal
//   Yuneec (CGO3+)                xmp:CameraYaw/Pitch/Roll         camera, horizon zero      -> kGimbal
//   Teal                          exif:Platform* + exif:Camera*    summed, horizon zero       -> kGimbal
//   Autel (old)                   Camera:Yaw/Pitch/Roll            gimbal, nadir zero: pitch - 90 -> kGimbal
//   Autel (XL715, some firmware)  Camera:Yaw/Pitch/Roll, pitch below -10: horizon zero        -> kGimbal
//     (of others below -60)
//   Sequoia, senseFly, Sentera, Pix4D  Camera:Yaw/Pitch/Roll       nadir zero                 -> kAirframe
//   Phase One                     aerialgps:GPSIMUYaw/Pitch/Roll   camera, horizon zero       -> kGimbal
//   senseFly (old)                sensefly:Heading.../Yaw...       nadir zero                 -> kAirframe
//   DJI without gimbal angles     drone-dji:FlightYawDegree, maker note Yaw: heading only     -> kAirframe
// Nadir-zero angles turn a camera that looks straight down with the image top forward, by heading, nose up
// and right wing down: just the angles of an airframe to which that camera is fixed, so kAirframe takes them
// unchanged, exactly. (Taking 90 degrees off the pitch would be exact only without roll: a gimbal's roll
// turns about the optical axis.) The airframe of a DJI is tilted while its gimbal holds the camera level, so
// only its heading is taken. What was corrected or refused is added to `notes`. Any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

// The angles in DJI's maker note: floats that older models write beside, or instead of, XMP. A few lines of
// our own; bounded to the note's bytes. Degrees as found; camera pitch 0 = horizon. Source: the
// tag list of ExifTool's documentation (DJI tags 0x06..0x0b).
struct DjiMakerNote {
  std::optional<double> pitch_deg, yaw_deg, roll_deg;
  std::optional<double> camera_pitch_deg, camera_yaw_deg, camera_roll_deg;
};

// `note` is the value of EXIF tag 0x927C: a TIFF directory without a header of its own, which keeps the
// camera's byte order when a program writes the EXIF block around it anew in the other; the order of the EXIF
// is tried first. Nothing when it is not DJI's.
std::optional<DjiMakerNote> ReadDjiMakerNote(std::span<const std::uint8_t> note, bool exif_is_big_endian);

std::optional<RecordedAttitude> AttitudeFromTags(const XmpTags& xmp,
                                                 const std::optional<DjiMakerNote>& maker_note,
                                                 const std::string& make, std::vector<Remark>& notes);

// EXIF's GPSImgDirection is that of the picture as its orientation tag turns it. Nothing for exactly 0, which
// devices write that do not know it.
std::optional<RecordedDirection> DirectionFromTags(const ExifRecord& exif);

// East, north, up from drone-dji Flight{X,Y,Z}Speed (NED), Camera:IMULinearVelocity (ENU).
std::optional<Eigen::Vector3d> VelocityFromTags(const XmpTags& xmp);

// How a camera turned while it read its rows, by the gyro that it recorded into the photo.
// Camera:IMUAngularVelocity is base64 of 24-byte little-endian records: microseconds of the camera's clock
// (u64), rad/s about x, y, z (3 x f32), a flag (u32); Camera:IMUTimeOffset are the nanoseconds from the first
// record to the first row. Its axes are the body's: on a flight of a Parrot Sequoia these alone of all 48
// ways to name them, mirrored ones too, bring the photos' rows together. Out: samples in time order, seconds
// since the first row began, about the axes of `cam` (x right, y down, z forward). Damaged or impossible
// records give nothing and a note. At most 4096 records.
std::optional<RecordedTurning> TurningFromTags(const XmpTags& xmp, std::vector<Remark>& notes);

}  // namespace skyquilt::flight
