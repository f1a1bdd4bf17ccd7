// Physics that the columns of a CSV log must obey, on its first rows: finds the units and axes that headers
// do not state and contradictions with those they do. Pure; any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/logs/csv/csv_rows.h"
#include "core/flight/logs/csv/sensor_units.h"

namespace skyquilt::flight {

struct CsvFindings {
  CsvClockRule clock;
  SensorAxes axes;
};

// Corrects the scales in `columns` where the unit was not written, by the first rows of the file. Errors:
// kUnprocessable naming the column.
Result<CsvFindings> CheckCsvPhysics(std::vector<CsvColumn>& columns, std::vector<CsvRow>& preview);

}  // namespace skyquilt::flight
