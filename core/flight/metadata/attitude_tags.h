// The makers' conventions for recorded angles, brought to ours (photo.h: yaw clockwise from true north, pitch
// 0 = horizon for the camera, intrinsic Z-Y-X in NED). In the order tried:
//   DJI, Hasselblad, Autel (new)  drone-dji:Gimbal*Degree          camera, horizon zero       -> kGimbal
//   DJI maker note                CameraPitch/Yaw/Roll             camera, horizon zero       -> kGimbal
//   Parrot ANAFI                  drone-parrot:Camera*Degree       camera, horizon zero       -> kGimbal
//   Skydio                        drone-skydio:CameraOrientationNED camera, horizon zero      -> kGimbal
//   Teal                          exif:Platform* + exif:Camera*    summed, horizon zero       -> kGimbal
//   Autel (old)                   Camera:Yaw/Pitch/Roll            gimbal, nadir zero: pitch - 90 -> kGimbal
//   Sequoia, senseFly, Sentera, Pix4D  Camera:Yaw/Pitch/Roll       nadir zero                 -> kAirframe
//   senseFly (old)                sensefly:Heading.../Yaw...       nadir zero                 -> kAirframe
//   DJI without gimbal angles     drone-dji:FlightYawDegree, maker note Yaw: heading only     -> kAirframe
// Nadir-zero angles turn a camera that looks straight down with the image top forward, by heading, nose up
// and right wing down: just the angles of an airframe to which that camera is fixed, so kAirframe takes them
// unchanged, exactly. (Taking 90 degrees off the pitch would be exact only without roll: a gimbal's roll
// turns about the optical axis.) The airframe of a DJI is tilted while its gimbal holds the camera level, so
// only its heading is taken.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/metadata/dji_maker_note.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

// Any thread. What was corrected or refused is added to `notes`.
std::optional<RecordedAttitude> AttitudeFromTags(const XmpTags& xmp,
                                                 const std::optional<DjiMakerNote>& maker_note,
                                                 const std::string& make, std::vector<Remark>& notes);

// East, north, up from drone-dji Flight{X,Y,Z}Speed (north, east, down), Camera:IMULinearVelocity (east,
// north, up).
std::optional<RecordedVelocity> VelocityFromTags(const XmpTags& xmp);

}  // namespace skyquilt::flight
