// The flights that a look at folders shows (FlightsOf), each with its photos and what lies beside them, and
// whether it stands still. Photos of one camera (maker, model, serial number) in one roll, without a longer
// pause between two of them than the rules' gap, are one. A roll is a folder; folders that a camera numbers
// as they fill (DCIM/100MEDIA, DCIM/101MEDIA) are one roll. A photo without a time goes with the one before
// it by name. Pure; any thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"
#include "server/watch/card_files.h"

namespace skyquilt::server {

struct CardPhoto {
  std::filesystem::path path;
  std::string camera;  // all that tells one camera from another
  std::optional<flight::UtcTime> taken_at;
};

// The photos of a card as indices, flight by flight: within one in the order of time, flights in the order of
// their paths and times.
std::vector<std::vector<std::size_t>> GroupPhotos(std::vector<CardPhoto> photos, std::chrono::seconds gap);

// The folder of a photo, with stars for the number that a camera gave it: "DCIM/100MEDIA" is "DCIM/***MEDIA".
std::filesystem::path RollOf(const std::filesystem::path& photo);
// Whether the name of a folder says nothing of a flight: given by a camera (DCIM, 100MEDIA), or "images".
bool SaysNothing(const std::filesystem::path& folder);

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
