// Physics that the columns of a CSV log must obey, on its first rows: finds the units and axes that headers
// do not state, by gravity, turns, the course, the air, and contradictions with those they do. Angles in
// radians, NED. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/csv/csv_rows.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// Meanings from the first to the last.
struct CsvMeanings {
  CsvMeaning first = CsvMeaning::kIgnored, last = CsvMeaning::kIgnored;
};

// The columns of these meanings, and their numbers in the first rows.
void Rescale(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview, CsvMeanings meanings,
             double factor, const char* unit);

// kUnprocessable, with the column's name.
Error Contradiction(const CsvColumn& column, Remark why);

// Nothing where the row has none, or one off the Earth.
std::optional<geo::LatLon> PlaceOf(const CsvRow& row);

struct SensorAxes {
  bool imu_z_is_up = false;
  std::vector<std::string> notes;  // for FlightLog::mapping
};

// Force in g, mg or m/s2, rates in degrees or radians a second, where the axes point. Error: Contradiction.
Result<SensorAxes> SettleInertialUnits(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview,
                                       double seconds_per_time);

// Angles that are read as degrees and keep to the course of the positions as radians alone; omega, phi and
// kappa that go beyond a full turn of degrees are gons.
void SettleAngleUnits(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview);

// Pascals, hectopascals, kilopascals and inches of mercury differ by more than the weather and any flight.
void SettlePressureUnit(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview);

// Latitudes and longitudes may be whole numbers of 1e-7 degrees, and heights beside them in millimetres.
// Error: Contradiction, where they are no degrees at all; nothing is changed then.
Result<void> SettlePositions(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview);

struct CsvFindings {
  CsvClockRule clock;
  SensorAxes axes;
  std::vector<Remark> warnings;
};

// All of them. Corrects the scales in `columns` where the unit was not written, by the first rows of the
// file. Errors: kUnprocessable naming the column.
Result<CsvFindings> CheckCsvPhysics(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview);

}  // namespace skyquilt::flight
