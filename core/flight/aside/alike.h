// What two pictures have in common by their size and by what took them. Pure; any thread.
#pragma once

#include <cstddef>

#include "core/flight/photo.h"

namespace skyquilt::flight {

// How many of one name or moment are looked at for one picture.
inline constexpr std::size_t kMaxLookedAt = 64;

inline constexpr double kMaxThermalPx = 1.4e6;  // of a sensor: visible pictures are larger

double PhotoPixels(const Photo& photo);

// Whether `a` is within `share` of `b`.
bool AreNear(double a, double b, double share);

// Whether focal lengths do not say that one sees more than the other.
bool SeeAlike(const Photo& a, const Photo& b);

// Of fewer pixels, of the same aspect and view.
bool IsReducedTo(const Photo& copy, const Photo& original);

// One shutter opens a thermal and a visible sensor, and writes one name into two folders.
bool AreOfTwoSensors(const Photo& a, const Photo& b);

}  // namespace skyquilt::flight
