// bench_poses [SEEDS]: what the pose stage reaches, printed as tables beside the figures it is measured
// against.
#include <cstdlib>

#include "tests/bench/poses/accuracy_table.h"

int main(int argc, char** argv) {
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 20;
  skyquilt::bench::PrintAccuracyTable(seeds > 0 ? seeds : 1);
  return 0;
}
