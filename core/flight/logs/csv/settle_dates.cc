#include "core/flight/logs/csv/settle_dates.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

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

}  // namespace

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

}  // namespace skyquilt::flight
