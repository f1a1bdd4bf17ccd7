// bench_poses [all|table|drift|integration|hop] [SEEDS [FOLDER_OF_LOGS or, for table, THE ROW]]: what the
// pose stage reaches, printed as tables beside the figures it is measured against. table: accuracy by kind of
// record; drift: real logs, dead reckoning and bridged holes; integration: trapezoid against Simpson; hop: a
// short flight without GNSS. The folder of real DataFlash or ULog logs may also come from SKYQUILT_DATA
// (logs/dataflash under it).
#include <cstdlib>

#include "tests/bench/poses/tables.h"

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "all";
  const int asked = argc > 2 ? std::atoi(argv[2]) : 20;
  const int seeds = asked > 0 ? asked : 1;
  const char* data = std::getenv("SKYQUILT_DATA");
  const std::string beside = SKYQUILT_SOURCE_DIR "/../shared/data";
  const std::string folder = argc > 3 ? argv[3] : (data ? std::string(data) : beside) + "/logs/dataflash";
  const bool all = what == "all";
  if (all || what == "integration") skyquilt::bench::PrintIntegrationTable(seeds);
  if (all || what == "hop") skyquilt::bench::PrintPaperHop(seeds);
  if (all || what == "drift") skyquilt::bench::PrintRealLogs(folder);
  if (all || what == "table")
    skyquilt::bench::PrintAccuracyTable(seeds, what == "table" && argc > 3 ? argv[3] : "");
  return 0;
}
