// ShownPhotos: which photos each block of a planned map may show, so that whoever renders a range of blocks
// fetches no others. Written as CBOR (RFC 8949) by whoever placed the flight. Values; any thread. Errors: of
// ParseShown kCorrupt.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/pipeline/plan_map.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/units/flight_cut.h"

namespace skyquilt::pipeline {

struct ShownPhotos {
  std::vector<std::string> names;                     // of all placed photos
  std::vector<std::vector<std::uint32_t>> of_blocks;  // indices of `names`, rising

  // Of a range of blocks; what lies beyond the last block shows nothing.
  std::set<std::string> NamesIn(const UnitRange& blocks) const;
};

// `planned`: of the whole map.
ShownPhotos FindShown(const FlightFacts& facts, const PlannedMap& planned);

std::string WriteShown(const ShownPhotos& shown);
Result<ShownPhotos> ParseShown(std::string_view bytes);

}  // namespace skyquilt::pipeline
