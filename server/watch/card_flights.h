// CardFlights: the flights that a look at folders shows, each with its photos and what lies beside them, and
// whether it stands still. Pure; any thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "server/watch/card_files.h"

namespace skyquilt::server {

struct CardFlight {
  std::string name;                           // for people
  std::vector<std::filesystem::path> photos;  // in the order of time
  std::vector<std::filesystem::path> beside;
  std::size_t cut_photos = 0;  // left out: without their ends
  bool is_settled = false;
  std::uint64_t bytes = 0;
  std::string signature;  // the same as long as nothing of it changed
};

struct FlightRules {
  std::chrono::seconds gap{1800};
  std::chrono::milliseconds settle{20'000};
  std::size_t min_photos = 1;
};

std::vector<CardFlight> FlightsOf(const CardFiles& card, const FlightRules& rules,
                                  CardFile::Clock::time_point now);

}  // namespace skyquilt::server
