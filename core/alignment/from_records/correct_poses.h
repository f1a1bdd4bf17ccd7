// Which records the images proved wrong: whole flights whose camera is mounted sideways, photos stored turned
// by a quarter or half, yaw of something else than the camera, positions far off; and the poses to start the
// adjustment from, by the corrections of the ground graph. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/from_records/ground_graph.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// The turn about the vertical, counter-clockwise, that every photo of a flight needs: 0, or +-pi/2, or pi
// where at least four of five pairs (and no fewer than eight) say so. Between themselves the photos of a
// camera mounted sideways agree; what gives them away is the way from one to the next, which the pictures
// show turned against the recorded positions. `pairs` of views as recorded.
double CommonQuarterTurn(const std::vector<PhotoGround>& recorded, const std::vector<PhotoPair>& pairs);

PhotoFindings CorrectPose(const poses::PosedPhoto& posed, const PhotoGround& ground);

// For a pose found from the images alone: what it says of the record.
PhotoFindings CorrectToPose(const poses::PosedPhoto& posed, PhotoGround ground,
                            const geo::Rigid3& cam_from_enu);

// Of a photo without a recorded yaw that lies across where the course bends: the course says little of it
// there, and the picture is no worse for that, unless its neighbours of the same camera, or most of its
// photos, lie the same way. `recorded`: as many as are corrected, in the order of capture.
void ForgiveTurnsAtBends(const std::vector<poses::PosedPhoto>& recorded,
                         std::vector<PhotoFindings>& corrected);

// For whole lines and single photos.
std::vector<flight::Remark> DescribeCorrections(const std::vector<PhotoFindings>& corrected,
                                                const std::vector<std::string>& names,
                                                const std::vector<int>& lines);

}  // namespace skyquilt::alignment
