// What a repair reads of a data folder that anything may have happened to: records of flights, and the
// marker.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "storage/catalogue/flight_record.h"
#include "storage/db/ids.h"
#include "storage/folder/data_marker.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const skyquilt::storage::FlightRecord record = skyquilt::storage::ParseFlightRecord(text);
  SKYQUILT_CHECK(!record.is_whole || record.name, "a whole record without its flight");
  const auto id = skyquilt::storage::ParseMarker(text);
  SKYQUILT_CHECK(!id || skyquilt::storage::IsId(*id), "a marker with an id that could be a path");
  return 0;
}
