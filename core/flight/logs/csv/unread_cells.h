// UnreadCells: which cells of known columns could not be read while a table was, so that it can be said.
// Holds three cells a column. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/logs/csv/csv_columns.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// A cell without a value: empty, or a word for it ("-", "n/a", "nan").
bool IsEmptyCell(std::string_view cell);

class UnreadCells {
 public:
  void Count(std::size_t column, bool is_read, std::size_t line, std::string_view cell);
  // A warning for each of the first three cells of a column and one for the others; for a column of which
  // nothing was read, one that names its first cell and what is read.
  void Tell(const std::vector<CsvColumn>& columns, LogBuilder& builder) const;
  // What is said of a column of these meanings of which nothing was read; nothing where none is so.
  std::optional<Remark> WhyNothing(const std::vector<CsvColumn>& columns, CsvMeaning first,
                                   CsvMeaning last) const;

 private:
  struct Cell {
    std::size_t line = 0;
    std::string text;
  };
  struct Column {
    std::uint64_t read = 0;
    std::uint64_t unread = 0;
    std::vector<Cell> first;
  };
  Remark NothingRead(const CsvColumn& column, const Column& cells) const;

  std::vector<Column> columns_;
};

}  // namespace skyquilt::flight
