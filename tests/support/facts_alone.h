// FactsAlone: of an earlier run what it knew of the flight, and no tiles: all blocks are rendered again.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/pyramid/map_memory.h"

namespace skyquilt::test {

class FactsAlone final : public pyramid::MapMemory {
 public:
  std::optional<Digest> DigestOf(const geo::TileId& /*block*/) const override { return std::nullopt; }
  Result<pyramid::KeptBlock> Reuse(const geo::TileId& /*block*/, const Digest& /*digest*/,
                                   std::optional<int> /*fringe_quality*/) override {
    return pyramid::KeptBlock{};
  }
  Result<void> Keep(const geo::TileId& /*block*/, const Digest& /*digest*/,
                    const pyramid::KeptBlock& /*kept*/) override {
    return {};
  }
  const std::string& Recall() const override { return facts_; }
  Result<void> Remember(std::string_view facts) override {
    facts_ = facts;
    return {};
  }

 private:
  std::string facts_;
};

}  // namespace skyquilt::test
