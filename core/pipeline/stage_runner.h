// StageRunner: runs one stage after the other: says which begins and times it. One thread.
#pragma once

#include "core/base/progress.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::pipeline {

class StageRunner {
 public:
  StageRunner(MosaicReport& report, Progress& progress) : report_(report), progress_(progress) {}

  template <typename Stage>
  auto Run(const char* name, Stage&& stage) {
    progress_.BeginStage(name);
    report_.timings.push_back({name, 0.0, 0.0});
    const TraceSpan span(name);
    ScopedTimer timer(report_.timings.back().wall_s);
    ScopedCpuTimer cpu_timer(report_.timings.back().cpu_s);
    return stage();
  }

 private:
  MosaicReport& report_;
  Progress& progress_;
};

}  // namespace skyquilt::pipeline
