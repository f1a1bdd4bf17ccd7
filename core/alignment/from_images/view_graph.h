// BuildViewGraph: the pairs of photos that show the same by what they show, each verified by the geometry of
// two views, and all of them by each other: a pair whose turn contradicts what the others say round every
// loop is refused (repeated texture). The same for any number of threads.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/alignment/estimators/two_view.h"
#include "core/alignment/matching/pair_sources.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/registration.h"
#include "core/base/progress.h"

namespace skyquilt::alignment {

struct ViewGraphOptions {
  CandidateOptions candidates;
  int features = 800;           // compared first
  int features_of_weak = 2000;  // of photos that are left with very few partners
  int enough_partners = 6;      // photos with fewer are compared with more
  int few_partners = 3;
  TwoViewOptions two_view;
};

// What looks the same in two photos, whether or not any geometry agrees with it.
struct ComparedPair {
  int first = 0, second = 0;
  std::vector<KeypointMatch> matches;
};

struct ViewGraph {
  std::vector<ComparedPair> compared;              // with enough matches for a geometry
  std::vector<GraphPair> pairs;                    // sorted
  std::vector<Eigen::Quaterniond> cam_from_world;  // averaged, by photo; one world a component
  std::vector<int> component;                      // negative: no pair
};

ViewGraph BuildViewGraph(const RegistrationInput& input, const ViewGraphOptions& options, int threads,
                         RegistrationReport& report, Progress& progress);

// The same photos through other lenses: what was compared is verified anew.
void VerifyAgain(const RegistrationInput& input, const ViewGraphOptions& options, int threads,
                 RegistrationReport& report, ViewGraph& graph);

}  // namespace skyquilt::alignment
