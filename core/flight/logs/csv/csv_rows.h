// Rows of a CSV log with mapped columns, as numbers and then as samples. One thread.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/csv/unread_cells.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {

// Of a table, before its rows are read.
inline constexpr std::size_t kRowsLookedAhead = 5000, kBytesLookedAhead = std::size_t{16} << 20;

// The cells of one row by meaning, in our units.
struct CsvRow {
  std::array<std::optional<double>, static_cast<std::size_t>(CsvMeaning::kCount)> number;
  std::optional<WrittenTime> written;  // its date and time of day
  std::string_view event;
  std::string_view image;  // a name, also where the column of exposures holds names
  std::string_view fix;

  std::optional<double> operator[](CsvMeaning meaning) const {
    return number[static_cast<std::size_t>(meaning)];
  }
  bool Has(CsvMeaning first, CsvMeaning last) const;
};

// The value of a cell in the unit of its column's meaning; nothing where it cannot be read.
std::optional<double> ReadCsvNumber(const CsvColumn& column, std::string_view cell);

// `unread` is told of each cell of a known column; may be null.
CsvRow ReadCsvRow(const std::vector<CsvColumn>& columns, const std::vector<std::string_view>& cells,
                  UnreadCells* unread = nullptr, std::size_t line = 0);

// What must be known of a whole file before its rows can be placed in time.
struct CsvClockRule {
  bool has_time_column = false;
  double first_time_s = 0.0;   // subtracted, so that large counters stay exact
  bool time_is_unix = false;   // the time column counts from 1970
  double rows_per_tick = 1.0;  // above 1: the date column ticks coarser than the rows come
  bool utc_is_utc = true;      // false: a local clock of unknown zone
};

// Of a row that names a photo its coordinates as written; its heights, and the camera's own angles, else the
// others, which are of `kind`.
void TakePose(const CsvRow& row, AttitudeKind kind, CameraEvent& event);

// What came of the rows below the names of their columns.
struct SampledRows {
  std::uint64_t rows = 0, without_time = 0;
  UnreadCells unread;

  // Of the cells and rows that could not be read.
  void Tell(const std::vector<CsvColumn>& columns, LogBuilder& builder) const;
};

// Turns rows into samples. Also the axes of the IMU: flips y and z where the file's z points up.
class CsvSampler {
 public:
  CsvSampler(LogBuilder& builder, const CsvClockRule& clock, bool imu_z_is_up, bool baro_is_relative)
      : builder_(builder), rule_(clock), imu_z_is_up_(imu_z_is_up), baro_is_relative_(baro_is_relative) {}

  // False where the row has no time.
  bool Take(const CsvRow& row);
  // Sets the log's clock, its zero of barometric heights and what its columns were taken for.
  void Finish(const std::vector<CsvColumn>& columns, const SampledRows& sampled);

 private:
  std::optional<double> PlaceInTime(const CsvRow& row);
  void TakeEvent(const CsvRow& row, double t_s);

  LogBuilder& builder_;
  CsvClockRule rule_;
  bool imu_z_is_up_;
  bool baro_is_relative_;
  ClockPairs clock_;
  double clock_resolution_s_ = 0.0;
  std::optional<UtcTime> first_utc_;
  std::optional<double> last_tick_s_;
  double rows_in_tick_ = 0.0;
  double newest_offset_s_ = -1e18;
  bool was_photo_ = false;
  std::string_view last_image_;  // a view into the file's text
  std::int64_t photos_ = 0;
};

// All of them.
SampledRows SampleRows(const std::vector<CsvColumn>& columns, char separator, LineReader& lines,
                       const ConsumedUpTo& consumed, CsvSampler& sampler);

}  // namespace skyquilt::flight
