// ReadRadiometry: the radiometry of one photo of one band from its tags. Never fails: what a maker's formula
// needs and the tags lack or contradict is left out of it, and `calibration` says how far it came. Pure; any
// thread. Sources:
//   Parrot Sequoia: application notes SEQ-AN-01 (vignetting by a polynomial of the plane, sensor model,
//   exposure)
//     and SEQ-AN-02 (sunshine sensor). Where the camera carries the measurements by which its factory
//     calibrated camera and sunshine sensor under one light (Camera:CalibrationMeasurement: gain, exposure
//     time, level of 10 bits; Camera:IrradianceCalibrationMeasurement), both are counted in that light, which
//     brings the bands near each other; no document says what the camera looked at then, so that factors stay
//     open. Otherwise by Camera:SensorModel.
//   MicaSense RedEdge, Altum: "Radiometric calibration model for MicaSense sensors":
//     L = V(x, y) * a1 / gain * (p - pBL) / (te + a2 y - a3 te y) with p a share of 65536; reflectance is pi
//     L over the irradiance of the light sensor.
//   DJI P4 Multispectral, Mavic 3 Multispectral: their image processing guides: (level - black) / 65535 over
//     gain and exposure, times a radial polynomial, times SensorGainAdjustment, over Irradiance.
//   Any other: black level, exposure and gain of EXIF.
#pragma once

#include "core/bands/radiometry.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::bands {

Radiometry ReadRadiometry(const flight::ExifTable& exif, const flight::XmpTags& xmp);

}  // namespace skyquilt::bands
