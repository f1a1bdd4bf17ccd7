// DateOrderFinder: whether the dates of a table have the day or the month first, told apart by all of its
// rows. A number above 12 decides; else the order in which the times rise and lie closest together. One
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/flight/bytes/written_time.h"

namespace skyquilt::flight {

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

}  // namespace skyquilt::flight
