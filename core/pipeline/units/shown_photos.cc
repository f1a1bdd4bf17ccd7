#include "core/pipeline/units/shown_photos.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/pipeline/report/cbor_values.h"
#include "core/render/blocks/block_weights.h"

namespace skyquilt::pipeline {
namespace {

using Cbor = nlohmann::json;

// Raised whenever the meaning or a name changes.
constexpr int kShownVersion = 1;

}  // namespace

std::set<std::string> ShownPhotos::NamesIn(const UnitRange& blocks) const {
  std::set<std::string> shown;
  for (std::size_t i = blocks.first; i < std::min(blocks.end, of_blocks.size()); ++i)
    for (const std::uint32_t photo : of_blocks[i]) shown.insert(names[photo]);
  return shown;
}

ShownPhotos FindShown(const FlightFacts& facts, const PlannedMap& planned) {
  ShownPhotos shown;
  for (const alignment::AlignedPhoto& photo : facts.flight.photos) shown.names.push_back(photo.photo.name);
  for (const render::RenderBlock& block : planned.plan.blocks) {
    const render::BlockCells cells(planned.seams, block.tile, planned.plan.block_levels);
    shown.of_blocks.push_back(cells.PhotosOf(block));
  }
  return shown;
}

std::string WriteShown(const ShownPhotos& shown) {
  Cbor names = Cbor::array(), blocks = Cbor::array();
  for (const std::string& name : shown.names) names.push_back(CborOfText<Cbor>(name));
  for (const auto& photos : shown.of_blocks) blocks.push_back(CborOfValues<Cbor>(photos));
  const std::vector<std::uint8_t> bytes =
      Cbor::to_cbor({{"version", kShownVersion}, {"names", std::move(names)}, {"blocks", std::move(blocks)}});
  return {bytes.begin(), bytes.end()};
}

Result<ShownPhotos> ParseShown(std::string_view bytes) {
  const auto broken = [](const char* why) {
    return Error{ErrorCode::kCorrupt,
                 "What is known of a part of the map is damaged. Stitch the flight again.", why};
  };
  try {
    const Cbor json = Cbor::from_cbor(bytes);
    if (json.at("version") != kShownVersion) return broken("another version wrote it");
    ShownPhotos shown;
    for (const Cbor& name : json.at("names")) shown.names.push_back(TextOfCbor(name));
    for (const Cbor& photos : json.at("blocks")) {
      shown.of_blocks.push_back(ValuesOfCbor<std::uint32_t>(photos));
      for (const std::uint32_t photo : shown.of_blocks.back())
        if (photo >= shown.names.size()) return broken("a block shows a photo that is not there");
    }
    return shown;
  } catch (const Cbor::exception& failure) {
    return broken(failure.what());
  }
}

}  // namespace skyquilt::pipeline
