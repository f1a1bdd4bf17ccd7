// WhyImplausible: which photos no map can be drawn with where their poses put them: poses that are not
// numbers, cameras on or below the ground, beyond the ends of Web Mercator, or so far away or so high that
// one photo would decide the extent and the memory of the whole map. Looking up or along the horizon is no
// fault: such a photo just shows no ground, or little. Frame: enu of the flight. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/flight/photo.h"
#include "core/geo/local_frame.h"
#include "core/geo/rigid3.h"

namespace skyquilt::poses {

inline constexpr double kHighestLatDeg = 85.0;  // Web Mercator ends at 85.05

struct CameraStand {
  camera::Intrinsics intrinsics;
  geo::Rigid3 cam_from_enu;
  double height_above_ground_m = 0.0;
};

// By stand: why, as a remark that goes on from the photo's name; nothing where all is well.
std::vector<std::optional<flight::Remark>> WhyImplausible(const std::vector<CameraStand>& stands,
                                                          const geo::LocalFrame& frame);

// "A.JPG was ... B.JPG was ... So it is with 12 more.": for a flight of which nothing is left.
flight::Remark FirstImplausible(const std::vector<flight::LeftOutPhoto>& left_out);

// Takes the implausible photos, posed or aligned, out of `photos` and adds them to `left_out`. How many.
template <typename Placed, typename StandOf>
std::size_t LeaveOutImplausible(const geo::LocalFrame& frame, const StandOf& stand_of,
                                std::vector<Placed>& photos, std::vector<flight::LeftOutPhoto>& left_out) {
  std::vector<CameraStand> stands;
  stands.reserve(photos.size());
  for (const Placed& photo : photos) stands.push_back(stand_of(photo));
  const std::vector<std::optional<flight::Remark>> why = WhyImplausible(stands, frame);
  std::size_t number = 0;
  return std::erase_if(photos, [&](const Placed& photo) {
    const std::optional<flight::Remark>& reason = why[number++];
    if (reason) left_out.push_back({photo.photo.name, ErrorCode::kNoPosition, *reason});
    return reason.has_value();
  });
}

}  // namespace skyquilt::poses
