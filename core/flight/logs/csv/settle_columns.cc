#include "core/flight/logs/csv/settle_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <tuple>

#include "core/base/text/file_names.h"
#include "core/flight/bytes/written_time.h"
#include "core/flight/logs/csv/csv_rows.h"
#include "core/flight/logs/csv/list_columns.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

using M = CsvMeaning;
constexpr std::size_t kDateBytesLookedAt = std::size_t{64} << 20;
constexpr std::uint64_t kClocksLookedAt = 200;  // cells a column: each is tried as all kinds of times
constexpr std::array kAllOrders = {DateOrder::kYearFirst, DateOrder::kDayFirst, DateOrder::kMonthFirst,
                                   DateOrder::kShortYearFirst};

bool IsClock(M meaning) { return meaning >= M::kTime && meaning <= M::kTimeOfDay; }
bool MayNamePhoto(M meaning) { return meaning == M::kImage || meaning == M::kIsPhoto; }

// What the cells of one column are.
struct CellCounts {
  std::uint64_t filled = 0;
  std::uint64_t numbers = 0;
  std::array<std::uint64_t, 5> marks{};  // by MarkEvidence
  std::uint64_t changes = 0;             // cells unlike the one above
  std::uint64_t names = 0;               // neither numbers nor flags
  std::uint64_t pictures = 0;            // names with the ending of one
  std::string_view last;
  // Of the first ones of a column of times:
  std::uint64_t clocks = 0;
  std::uint64_t clock_numbers = 0;
  std::uint64_t stamps = 0;
  std::uint64_t dates = 0;
  std::uint64_t times_of_day = 0;
  std::uint64_t elapsed = 0;
  std::uint64_t year_first = 0;

  std::uint64_t Marks(MarkEvidence evidence) const { return marks[static_cast<std::size_t>(evidence)]; }
  bool AreMostly(std::uint64_t kind) const { return clocks > 0 && 2 * kind >= clocks; }
  bool ArePictures() const { return filled > 0 && 2 * pictures >= filled; }
  bool Differ() const { return filled > 0 && 10 * changes >= 9 * filled; }
};

void CountClock(std::string_view cell, CellCounts& counts) {
  if (counts.clocks >= kClocksLookedAt) return;
  ++counts.clocks;
  const auto number = ReadNumber(cell);
  counts.clock_numbers += number && !ParseElapsed(cell) &&
                          (number->unit.empty() || FactorOfUnitBehind(number->unit, Dimension::kTime));
  counts.times_of_day += IsTimeOfDay(cell);
  counts.elapsed += ParseElapsed(cell).has_value();
  const auto reads = [&](auto parse) { return std::any_of(kAllOrders.begin(), kAllOrders.end(), parse); };
  counts.stamps += reads([&](DateOrder order) { return ParseWrittenTime(cell, order).has_value(); });
  counts.dates += reads([&](DateOrder order) { return ParseDate(cell, order).has_value(); });
  counts.year_first += ParseDate(cell, DateOrder::kYearFirst).has_value();
}

void CountCell(const CsvColumn& column, std::string_view cell, CellCounts& counts) {
  ++counts.filled;
  counts.changes += cell != counts.last;
  counts.last = cell;
  if (IsClock(column.meaning)) CountClock(cell, counts);
  const Dimension dimension = CsvMeaningDimension(column.meaning);
  if (dimension == Dimension::kNone) {
    const std::string lower = LowerCase(cell.substr(0, 8));
    counts.names +=
        !ParseNumber(cell) && lower != "true" && lower != "false" && lower != "yes" && lower != "no";
    counts.pictures += MayNamePhoto(column.meaning) && IsNamedAsPicture(cell);
    return;
  }
  counts.numbers += ReadCsvNumber(column, cell).has_value();
  MarkEvidence evidence = EvidenceOfMark(cell);
  if (dimension == Dimension::kCoordinate && evidence == MarkEvidence::kLoneComma)
    evidence = MarkEvidence::kComma;
  if (dimension == Dimension::kCoordinate && evidence == MarkEvidence::kLonePoint)
    evidence = MarkEvidence::kPoint;
  ++counts.marks[static_cast<std::size_t>(evidence)];
}

struct TableCounts {
  std::uint64_t rows = 0;
  std::uint64_t rows_too_long = 0;
  std::size_t first_long_line = 0;
  std::size_t first_long_cells = 0;
  std::vector<CellCounts> columns;
};

TableCounts CountCells(LineReader lines, char separator, const std::vector<CsvColumn>& columns) {
  TableCounts table;
  table.columns.resize(columns.size());
  const std::size_t end = lines.offset() + kBytesLookedAhead;
  std::vector<std::string_view> cells;
  while (table.rows < kRowsLookedAhead && NextRow(lines, separator, cells, end)) {
    ++table.rows;
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (cells.size() > columns.size() && ++table.rows_too_long == 1) {
      table.first_long_line = lines.line_number();
      table.first_long_cells = cells.size();
    }
    for (std::size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
      if (columns[i].meaning != M::kIgnored && !IsEmptyCell(cells[i]))
        CountCell(columns[i], cells[i], table.columns[i]);
    }
  }
  return table;
}

void MakeClock(CsvColumn& column, M meaning, const char* unit = "") {
  column.meaning = meaning;
  column.scale = 1.0;
  column.unit = unit;
}

void MakeSeconds(CsvColumn& column, bool is_text) {
  MakeClock(column, M::kTime, "s");
  column.unit_is_written = is_text;
  column.is_elapsed_text = is_text;
}

// A column of times by its cells rather than by its name.
void SettleClock(const CellCounts& counts, bool has_date, CsvColumn& column) {
  const bool is_numeric = counts.AreMostly(counts.clock_numbers);
  if (counts.AreMostly(counts.stamps)) return MakeClock(column, M::kUtc);
  if (column.meaning == M::kDate) return;
  if (has_date && counts.clocks > 0 && counts.times_of_day == counts.clocks)
    return MakeClock(column, M::kTimeOfDay);
  if (column.meaning == M::kTime && is_numeric) return;
  if (has_date && counts.AreMostly(counts.times_of_day)) return MakeClock(column, M::kTimeOfDay);
  if (counts.AreMostly(counts.elapsed)) return MakeSeconds(column, true);
  if (counts.AreMostly(counts.dates) && !is_numeric) return MakeClock(column, M::kDate);
  if (is_numeric) MakeSeconds(column, false);
}

void SettleClocks(const TableCounts& table, std::vector<CsvColumn>& columns) {
  bool has_date = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const CellCounts& counts = table.columns[i];
    has_date = has_date || (columns[i].meaning == M::kDate && counts.AreMostly(counts.dates) &&
                            !counts.AreMostly(counts.stamps));
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (IsClock(columns[i].meaning)) SettleClock(table.columns[i], has_date, columns[i]);
  }
}

bool IsReadable(const CsvColumn& column, const CellCounts& counts) {
  switch (column.meaning) {
    case M::kUtc:
      return counts.AreMostly(counts.stamps);
    case M::kDate:
      return counts.AreMostly(counts.dates);
    case M::kTimeOfDay:
      return counts.AreMostly(counts.times_of_day);
    case M::kTime:
      return counts.AreMostly(column.is_elapsed_text ? counts.elapsed : counts.clock_numbers);
    default:
      break;
  }
  if (CsvMeaningDimension(column.meaning) == Dimension::kNone) return counts.filled > 0;
  return counts.filled > 0 && 2 * counts.numbers >= counts.filled;
}

// How well the cells name photos: files of pictures, else each its own, and not the mission.
int WorthAsName(M meaning, const CellCounts& counts) {
  if (MayNamePhoto(meaning) && counts.ArePictures()) return 2;
  return meaning == M::kImage && counts.Differ() ? 1 : 0;
}

// Of columns with one meaning the first that can be read counts; of clocks one that says UTC before others,
// of names those of pictures.
void ChooseAmongRepeated(const TableCounts& table, std::vector<CsvColumn>& columns) {
  std::array<std::optional<std::size_t>, static_cast<std::size_t>(M::kCount)> best{};
  const auto worth = [&](std::size_t i) {
    const bool is_date = IsOfClock(columns[i].meaning);
    return std::tuple(IsReadable(columns[i], table.columns[i]), is_date && columns[i].says_utc,
                      WorthAsName(columns[i].meaning, table.columns[i]));
  };
  for (std::size_t i = 0; i < columns.size(); ++i) {
    auto& kept = best[static_cast<std::size_t>(columns[i].meaning)];
    if (!kept || worth(i) > worth(*kept)) kept = i;
  }
  const auto has = [&](M meaning) {
    const auto& column = best[static_cast<std::size_t>(meaning)];
    return column && IsReadable(columns[*column], table.columns[*column]);
  };
  const auto names_pictures = [&](M meaning) {
    const auto& column = best[static_cast<std::size_t>(meaning)];
    return column && table.columns[*column].ArePictures();
  };
  const bool photos_are_named_elsewhere = names_pictures(M::kIsPhoto) && !names_pictures(M::kImage);
  // A whole stamp does better than its halves, and half a stamp is none.
  const bool has_halves = !has(M::kUtc) && has(M::kDate) && has(M::kTimeOfDay);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const M meaning = columns[i].meaning;
    const bool is_half = meaning == M::kDate || meaning == M::kTimeOfDay;
    if (best[static_cast<std::size_t>(meaning)] != i || (is_half && has(M::kUtc)))
      columns[i].meaning = M::kIgnored;
    else if ((meaning == M::kUtc && has_halves) || (meaning == M::kImage && photos_are_named_elsewhere))
      columns[i].meaning = M::kIgnored;
  }
}

DecimalMark MarkOfColumn(const CellCounts& cells, std::uint64_t file_points, std::uint64_t file_commas,
                         char separator) {
  const bool has_points = cells.Marks(MarkEvidence::kPoint) > 0;
  const bool has_commas = cells.Marks(MarkEvidence::kComma) > 0;
  if (has_points != has_commas) return has_points ? DecimalMark::kPoint : DecimalMark::kComma;
  const bool lone_points = cells.Marks(MarkEvidence::kLonePoint) > 0;
  const bool lone_commas = cells.Marks(MarkEvidence::kLoneComma) > 0;
  if ((has_points && has_commas) || (lone_points && lone_commas)) return DecimalMark::kUnclear;
  if (lone_points && file_commas > 0) return DecimalMark::kUnclear;
  if (lone_commas && file_points > 0 && file_commas == 0)
    return separator == ',' ? DecimalMark::kPoint : DecimalMark::kUnclear;
  return DecimalMark::kUnknown;
}

void SettleMarks(const TableCounts& table, char separator, std::vector<CsvColumn>& columns) {
  std::uint64_t points = 0, commas = 0;
  for (const CellCounts& cells : table.columns) {
    points += cells.Marks(MarkEvidence::kPoint);
    commas += cells.Marks(MarkEvidence::kComma);
  }
  for (std::size_t i = 0; i < columns.size(); ++i)
    columns[i].mark = MarkOfColumn(table.columns[i], points, commas, separator);
}

// Whether the dates of a table have the day or the month first, told apart by all of its rows. A number above
// 12 decides; else the order in which the times rise and lie closest together.
class DateOrderFinder {
 public:
  // `time_of_day` may be empty, where it stands in the same cell or is not known.
  void Take(std::string_view date, std::string_view time_of_day, std::size_t line);

  struct Found {
    DateOrder order = DateOrder::kDayFirst;
    bool is_decided = true;  // false: nothing in the rows says so
    std::string why;         // "day first, as "23/06/2016" in line 2 says"
  };
  // Nothing where no row has a date in any of the orders.
  std::optional<Found> Find() const;

 private:
  static constexpr std::array kOrders = {DateOrder::kDayFirst, DateOrder::kMonthFirst,
                                         DateOrder::kShortYearFirst};
  struct Evidence {
    std::size_t line = 0;
    std::string cell;
  };
  struct Reading {
    std::uint64_t rows = 0;
    std::uint64_t falls = 0;
    std::optional<UtcTime> first, last, previous;
    // Of each other order, the first row that this one reads and the other does not.
    std::array<std::optional<Evidence>, kOrders.size()> against;
  };

  std::array<Reading, kOrders.size()> readings_;
  std::string first_cell_;
};

std::optional<UtcTime> InstantOf(std::string_view date, std::string_view time_of_day, DateOrder order) {
  const auto written =
      time_of_day.empty() ? ParseWrittenTime(date, order) : ParseWrittenTime(date, time_of_day, order);
  if (written) return written->time;
  const auto day = ParseDate(date, order);
  return day ? std::optional<UtcTime>(*day) : std::nullopt;
}

std::string_view NameOfOrder(DateOrder order) {
  if (order == DateOrder::kDayFirst) return "day first";
  return order == DateOrder::kMonthFirst ? "month first" : "year first";
}

// What is usual where nothing in the rows tells: month first where clocks have twelve hours.
DateOrder UsualOrder(std::string_view cell) {
  const bool has_twelve_hours = cell.find_first_of("Mm") != std::string_view::npos;
  return cell.find('/') != std::string_view::npos && has_twelve_hours ? DateOrder::kMonthFirst
                                                                      : DateOrder::kDayFirst;
}

void DateOrderFinder::Take(std::string_view date, std::string_view time_of_day, std::size_t line) {
  std::array<bool, kOrders.size()> is_read{};
  for (std::size_t i = 0; i < kOrders.size(); ++i) {
    const auto time = InstantOf(date, time_of_day, kOrders[i]);
    if (!time) continue;
    is_read[i] = true;
    Reading& reading = readings_[i];
    ++reading.rows;
    if (reading.previous && *time < *reading.previous) ++reading.falls;
    reading.previous = time;
    if (!reading.first || *time < *reading.first) reading.first = time;
    if (!reading.last || *time > *reading.last) reading.last = time;
  }
  if (std::none_of(is_read.begin(), is_read.end(), [](bool read) { return read; })) return;
  if (first_cell_.empty())
    first_cell_ = std::string(date.substr(0, 64)) + std::string(time_of_day.substr(0, 64));
  for (std::size_t i = 0; i < kOrders.size(); ++i) {
    for (std::size_t k = 0; k < kOrders.size(); ++k) {
      auto& against = readings_[i].against[k];
      if (is_read[i] && !is_read[k] && !against) against = Evidence{line, Quoted(date)};
    }
  }
}

std::optional<DateOrderFinder::Found> DateOrderFinder::Find() const {
  // Fewer is better: rows that cannot be read so, steps back in time, how long it all takes in whole days.
  const auto badness = [&](std::size_t i) {
    const Reading& reading = readings_[i];
    const auto days =
        reading.rows == 0
            ? 0
            : std::chrono::duration_cast<std::chrono::days>(*reading.last - *reading.first).count();
    return std::tuple(-static_cast<std::int64_t>(reading.rows), reading.falls, days);
  };
  std::array<std::size_t, kOrders.size()> ranked{0, 1, 2};
  std::stable_sort(ranked.begin(), ranked.end(),
                   [&](std::size_t a, std::size_t b) { return badness(a) < badness(b); });
  std::size_t best = ranked[0];
  if (readings_[best].rows == 0) return std::nullopt;
  Found found;
  const bool is_all_one = readings_[best].rows == readings_[ranked[1]].rows &&
                          readings_[best].first == readings_[ranked[1]].first &&
                          readings_[best].last == readings_[ranked[1]].last;
  found.order = kOrders[best];
  found.why = "the same in any order";
  if (is_all_one) return found;
  found.is_decided = badness(best) < badness(ranked[1]);
  if (!found.is_decided) {
    const auto usual = std::find(kOrders.begin(), kOrders.end(), UsualOrder(first_cell_)) - kOrders.begin();
    if (badness(static_cast<std::size_t>(usual)) == badness(best)) best = static_cast<std::size_t>(usual);
  }
  found.order = kOrders[best];
  const auto& evidence = readings_[best].against[found.is_decided ? ranked[1] : best];
  const bool is_by_rows = found.is_decided && readings_[best].rows > readings_[ranked[1]].rows;
  found.why = std::string(NameOfOrder(found.order));
  if (is_by_rows && evidence)
    found.why += fmt::format(", as {} in line {} says", evidence->cell, evidence->line);
  else if (found.is_decided)
    found.why += ", which keeps the rows together";
  else
    found.why += ", assumed: no row says whether the day or the month comes first";
  return found;
}

void SettleDates(const TableCounts& table, LineReader lines, char separator, std::vector<CsvColumn>& columns,
                 SettledColumns& settled) {
  CsvColumn* date = ColumnOf(columns, M::kUtc);
  if (date == nullptr) date = ColumnOf(columns, M::kDate);
  if (date == nullptr) return;
  const auto date_at = static_cast<std::size_t>(date - columns.data());
  if (2 * table.columns[date_at].year_first >= table.columns[date_at].clocks) return;
  const CsvColumn* time_of_day = date->meaning == M::kDate ? ColumnOf(columns, M::kTimeOfDay) : nullptr;
  const auto time_at = static_cast<std::size_t>(time_of_day == nullptr ? 0 : time_of_day - columns.data());
  DateOrderFinder finder;
  std::vector<std::string_view> cells;
  const std::size_t end = lines.offset() + kDateBytesLookedAt;
  while (NextRow(lines, separator, cells, end)) {
    if (date_at >= cells.size() || cells[date_at].empty()) continue;
    const bool has_time = time_of_day != nullptr && time_at < cells.size();
    finder.Take(cells[date_at], has_time ? cells[time_at] : std::string_view(), lines.line_number());
  }
  const auto found = finder.Find();
  if (!found) return;
  date->date_order = found->order;
  settled.notes.push_back(fmt::format("dates of column {} -> {}", Quoted(date->header), found->why));
  if (found->is_decided) return;
  const RemarkCode assumed = found->order == DateOrder::kDayFirst     ? RemarkCode::kDatesDayFirst
                             : found->order == DateOrder::kMonthFirst ? RemarkCode::kDatesMonthFirst
                                                                      : RemarkCode::kDatesYearFirst;
  settled.warnings.push_back({assumed, {{"column", Quoted(date->header)}}});
}

bool RowsNamePhotos(const TableCounts& table, const std::vector<CsvColumn>& columns) {
  const CsvColumn* image = ColumnOf(columns, M::kImage);
  if (image == nullptr) image = ColumnOf(columns, M::kIsPhoto);
  if (image == nullptr || !(HasDegrees(columns) || HasPlane(columns))) return false;
  const CellCounts& cells = table.columns[static_cast<std::size_t>(image - columns.data())];
  return table.rows > 0 && 10 * cells.changes >= 9 * table.rows && 10 * cells.names >= 9 * table.rows;
}

}  // namespace

Result<SettledColumns> SettleColumns(std::string_view name, LineReader lines, char separator,
                                     std::vector<CsvColumn>& columns) {
  const TableCounts table = CountCells(lines, separator, columns);
  const bool has_points =
      std::any_of(table.columns.begin(), table.columns.end(), [](const CellCounts& cells) {
        return cells.Marks(MarkEvidence::kPoint) + cells.Marks(MarkEvidence::kLonePoint) > 0;
      });
  if (separator == ',' && 2 * table.rows_too_long > table.rows && !has_points) {
    return Because(ErrorCode::kUnprocessable, {RemarkCode::kCommasUnclear,
                                               {{"file", name},
                                                {"cells", table.first_long_cells},
                                                {"line", table.first_long_line},
                                                {"headers", columns.size()}}});
  }
  SettledColumns settled;
  SettleClocks(table, columns);
  ChooseAmongRepeated(table, columns);
  SettleMarks(table, separator, columns);
  SettleDates(table, lines, separator, columns, settled);
  settled.rows_name_photos = RowsNamePhotos(table, columns);
  settled.rows_are_photos = settled.rows_name_photos && !HasColumn(columns, M::kTime);
  return settled;
}

}  // namespace skyquilt::flight
