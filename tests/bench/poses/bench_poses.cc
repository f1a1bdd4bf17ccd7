// bench_poses [SEEDS [FOLDER_OF_LOGS]]: what the pose stage reaches, printed as tables beside the figures it
// is measured against. The folder of real DataFlash or ULog logs may also come from SKYQUILT_DATA
// (logs/dataflash under it).
#include <cstdlib>
#include <string>

#include "tests/bench/poses/accuracy_table.h"
#include "tests/bench/poses/integration_table.h"
#include "tests/bench/poses/paper_hop.h"
#include "tests/bench/poses/real_logs.h"

int main(int argc, char** argv) {
  const int asked = argc > 1 ? std::atoi(argv[1]) : 20;
  const int seeds = asked > 0 ? asked : 1;
  const char* data = std::getenv("SKYQUILT_DATA");
  const std::string beside = SKYQUILT_SOURCE_DIR "/../shared/data";
  const std::string folder = argc > 2 ? argv[2] : (data ? std::string(data) : beside) + "/logs/dataflash";
  skyquilt::bench::PrintIntegrationTable(seeds);
  skyquilt::bench::PrintPaperHop(seeds);
  skyquilt::bench::PrintRealLogs(folder);
  skyquilt::bench::PrintAccuracyTable(seeds);
  return 0;
}
