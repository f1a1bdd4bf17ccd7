// GroupPhotos: which photos of a card or folder are one flight. Photos of one camera (maker, model, serial
// number) in one roll, without a longer pause between two of them than `gap`, are. A roll is a folder;
// folders that a camera numbers as they fill (DCIM/100MEDIA, DCIM/101MEDIA) are one roll. A photo without a
// time goes with the one before it by name. Pure; any thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::server {

struct CardPhoto {
  std::filesystem::path path;
  std::string camera;  // all that tells one camera from another
  std::optional<flight::UtcTime> taken_at;
};

// Indices of photos, flight by flight: within one in the order of time, flights in the order of their paths
// and times.
std::vector<std::vector<std::size_t>> GroupPhotos(const std::vector<CardPhoto>& photos,
                                                  std::chrono::seconds gap);

// The folder of a photo, with stars for the number that a camera gave it: "DCIM/100MEDIA" is "DCIM/***MEDIA".
std::filesystem::path RollOf(const std::filesystem::path& photo);
// Whether the name of a folder says nothing of a flight: given by a camera (DCIM, 100MEDIA), or "images".
bool SaysNothing(const std::filesystem::path& folder);

}  // namespace skyquilt::server
