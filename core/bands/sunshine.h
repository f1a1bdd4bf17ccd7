// The sunshine sensor of a Parrot Sequoia: what it measured around a photo, band by band. Bytes are a
// camera's and may be damaged: at most 4096 records. Any thread. Source: Parrot, application note SEQ-AN-02
// (records of Camera:IrradianceList); the gains of its light sensor by the data sheet of the AMS TSL2591.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace skyquilt::bands {

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

}  // namespace skyquilt::bands
