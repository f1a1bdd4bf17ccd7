// libFuzzer: any bytes as one cell of a table, and as a text in some encoding. Checked: what is read is
// finite, and decoding grows by half at most.
#include <cmath>
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/bytes/written_time.h"
#include "core/flight/logs/coordinate_cell.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::flight;
  const std::string_view cell(reinterpret_cast<const char*>(bytes), size);
  if (const auto read = ReadCoordinateCell(cell)) SKYQUILT_CHECK(std::isfinite(read->value), "no coordinate");
  if (const auto read = ReadNumberCell(cell)) SKYQUILT_CHECK(std::isfinite(*read), "no number");
  for (const DecimalMark mark : {DecimalMark::kPoint, DecimalMark::kComma, DecimalMark::kUnclear})
    ReadNumber(cell, mark);
  EvidenceOfMark(cell);
  if (const auto elapsed = ParseElapsed(cell)) SKYQUILT_CHECK(std::isfinite(*elapsed), "no time");
  for (const DateOrder order :
       {DateOrder::kYearFirst, DateOrder::kDayFirst, DateOrder::kMonthFirst, DateOrder::kShortYearFirst}) {
    ParseWrittenTime(cell, order);
    ParseWrittenTime(cell.substr(0, size / 2), cell.substr(size / 2), order);
  }
  const auto text = LogText::Of("fuzz", {bytes, size});
  SKYQUILT_CHECK(text && text->bytes().size() <= size + size / 2, "a text that grows");
  return 0;
}
