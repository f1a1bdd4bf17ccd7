// What the recorded poses and lenses mean to the search and to the adjustment: sigmas, priors, starting
// points. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/from_records/ground_graph.h"
#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// Which photos were taken on one straight flight line, within which gimbals and compasses err alike: a line
// number per photo (0, 1, ...), photos in order of capture. A turn ends a line; so does a gap of several
// times the usual spacing.
std::vector<int> FindLines(const std::vector<Eigen::Vector2d>& east_north);

// Without features, which the caller adds.
MatchedFlight MakeMatchedFlight(const poses::PosedFlight& posed);
std::vector<PhotoGround> MakeGrounds(const poses::PosedFlight& posed, const MatchedFlight& input);
double MedianWidthM(const std::vector<View>& views);
// Pairs of photos within one connected component, and every verified pair however little it overlaps. Others
// are too uncertain relative to each other for a narrow window: what matches there matches by chance.
std::vector<PhotoPair> OnlyWithinComponents(const std::vector<PhotoPair>& pairs,
                                            const std::vector<PhotoPair>& verified, std::size_t photos);

BundleProblem MakeBundle(const poses::PosedFlight& posed, const std::vector<PhotoFindings>& corrected,
                         const std::vector<int>& lines);
BundlePhoto MakeBundlePhoto(const poses::PosedPhoto& posed, const PhotoFindings& corrected, int lens,
                            int line);
// After a first adjustment the records show how good they are relative to each other: sigmas shrink to that.
// True: those of positions grew to a plain receiver's, for they claim far more than they hold. Adjusted
// again, ReweighPositions has them shrink to what the pictures leave of them. Angles grow once, by so much at
// most.
bool ReweighPriors(BundleProblem& problem);
bool ReweighPositions(BundleProblem& problem);

// The plane through most of a problem's points; none where they are too few.
std::optional<BundlePlane> FitPlane(const BundleProblem& problem);

}  // namespace skyquilt::alignment
