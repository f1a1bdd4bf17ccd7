// ReadRadiometry: the radiometry of one photo of one band from its tags. Never fails: what a maker's formula
// needs and the tags lack or contradict is left out of it, and `calibration` says how far it came. Pure; any
// thread. Sources:
//   Parrot Sequoia: application notes SEQ-AN-01 (vignetting by a polynomial of the plane, sensor model,
//   exposure)
//     and SEQ-AN-02 (sunshine sensor). Where the camera carries the measurements by which its factory
//     calibrated camera and sunshine sensor under one light (Camera:CalibrationMeasurement: gain, exposure
//     time, level of 10 bits; Camera:IrradianceCalibrationMeasurement), both are counted in that light, which
//     brings the bands near each other; no document says what the camera looked at then, so that factors stay
//     open. Otherwise by Camera:SensorModel (A, B, C): f^2 (level - B) / (A exposure_s ISO + C).
//   MicaSense RedEdge, Altum: "Radiometric calibration model for MicaSense sensors":
//     L = V(x, y) * a1 / gain * (p - pBL) / (te + a2 y - a3 te y) with p a share of 65536; reflectance is pi
//     L over the irradiance of the light sensor. Which firmwares wrote a wrong exposure time or a wrong
//     irradiance of level ground is told by MicaSense's own library (micasense/imageprocessing, metadata.py).
//   DJI P4 Multispectral, Mavic 3 Multispectral: their image processing guides: (level - black) / 65535 over
//     gain and exposure, times a radial polynomial, times SensorGainAdjustment, over Irradiance, unless
//     LS_status is 0 (a dongle covers the sensor).
//   Any other: black level, exposure and gain of EXIF.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/bands/radiometry.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::bands {

// The sunshine sensor of a Parrot Sequoia: what it measured around a photo, band by band. At most 4096
// records. Source: SEQ-AN-02 (records of Camera:IrradianceList); the gains of its light sensor by the data
// sheet of the AMS TSL2591.
struct SunshineRecord {
  double time_s = 0.0;         // of the camera's clock since it was switched on
  double counts_per_ms = 0.0;  // at gain 1
};

// base64 of 28-byte little-endian records: u64 microseconds, u16 counts of the band, u16 counts of the second
// diode, u16 gain index, u16 integration time in ms, three float angles. Nothing where it is damaged or
// empty; records that are saturated or of an unknown gain are left out.
std::optional<std::vector<SunshineRecord>> ReadIrradianceList(std::string_view text);

// Counts per ms at gain 1 under the light of the factory's calibration, by the most sensitive gain that did
// not saturate: Camera:IrradianceCalibrationMeasurement, four numbers a gain: index, integration time in ms,
// counts of the two diodes.
std::optional<double> CalibrationCounts(std::string_view text);

// The median of the last two seconds of the list.
double LastCounts(const std::vector<SunshineRecord>& records);

Radiometry ReadRadiometry(const flight::ExifTable& exif, const flight::XmpTags& xmp);

}  // namespace skyquilt::bands
