// ChooseIntrinsics: the camera of a photo from the best source it carries, in this order:
//   drone-dji:DewarpData               calibrated at the factory: focal lengths, centre, distortion
//   drone-dji:CalibratedFocalLength    pixels, often only nominal
//   Camera:PerspectiveFocalLength      mm (or pixels), with the focal plane resolution, or the sensor's size
//     by the table of sensors or the 35 mm equivalent, where these do not contradict it: its centre then
//     counts by the table alone, and near the middle
//   Camera:FisheyePolynomial           our lens model fitted to the calibrated fisheye
//   EXIF focal length and FocalPlaneXResolution, unless it is wrong: its unit, by 2.54, 10 or 25.4 off from
//     all that the next two say, or its picture's size, clearly off by another factor, or a sensor's size
//     that does not exist; said in a note. A crop mode to APS-C keeps it. FLIR writes a thermal sensor's
//     sides there, which are known by their shape
//   EXIF focal length and the table of sensors
//   EXIF 35 mm equivalent; before the table's, where by it the camera used a part of its sensor only
//   a usual drone lens (focal length 0.8 of the longer side), said in a note
// A digital zoom that the tags state counts in each; where the sources do not tell whether a calibration or
// an equivalent has it in already, it stays as it is, as kDoubtful. All of that is said in a note.
// Pixels of calibrations belong to the full sensor: they are scaled to a resized image, and kept for one that
// is cropped to another aspect (camera::ScaleFromNative). Any thread.
#pragma once

#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

struct ChosenIntrinsics {
  camera::Intrinsics intrinsics;
  FocalSource source = FocalSource::kAssumed;
};

ChosenIntrinsics ChooseIntrinsics(int width_px, int height_px, const ExifRecord& recorded, const XmpTags& xmp,
                                  std::vector<Remark>& notes);

// Pixels from a 35 mm equivalent, by its definition over the diagonal (CIPA DCG-001: 43.27 mm). Cameras keep
// the number when they crop their 4:3 sensor to a wide image, so the diagonal of an image wider than 3:2 is
// that of the 4:3 image of the same width.
double FocalPxFrom35mm(double focal_35mm, int width_px, int height_px);

}  // namespace skyquilt::flight
