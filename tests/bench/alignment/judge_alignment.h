// JudgeAlignment: an aligned simulated flight held against its truth and against what is demanded of it.
#pragma once

#include "core/alignment/scene/align_report.h"
#include "tests/bench/alignment/simulated_cases.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {

struct Judgement {
  GroundError error;       // of the photos nobody lied about
  GroundError pose_error;  // of the same by their recorded poses alone
  GnssError gnss;
  double worst_ratio = 0.0;  // the largest error of a photo over that of its record, without what all share
  int pairs = 0;
  int false_pairs = 0;  // that show different places as one
  double worst_pair_px = 0.0;
  int lies_told = 0, lies_found = 0;
  std::vector<std::string> faults;  // in words, what was missed; empty: all holds
};

struct AlignedCase {
  const simulate::SimulatedFlight* truth = nullptr;
  const Lies* lies = nullptr;
  const poses::PosedFlight* posed = nullptr;
  const AlignedFlight* aligned = nullptr;
  const ground::GroundSurface* surface = nullptr;
  const AlignReport* report = nullptr;
};

Judgement JudgeAlignment(const AlignedCase& flown, const Demands& demands);

}  // namespace skyquilt::alignment
