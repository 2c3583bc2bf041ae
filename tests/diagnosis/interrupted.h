// A diagnosis that is stopped when a stage begins.
#pragma once

#include <filesystem>
#include <string>

#include "diagnosis/diagnosis.h"
#include "physics/simulator.h"

namespace lacuna::test {

/// `options` with a checkpoint at `file`, stopped through `stop` as soon as the name of a stage holds `stage`.
inline DiagnoseOptions stopping_at(DiagnoseOptions options, const std::filesystem::path& file, const std::string& stage,
                                   StopFlag& stop) {
  options.identify.control.checkpoint = file;
  options.identify.control.problem = "stopped";
  options.identify.control.stop = &stop;
  options.identify.simulator.stop = &stop;
  options.identify.control.progress = [stage, &stop](const Progress& p) {
    if (p.stage.find(stage) != std::string::npos) stop = true;
  };
  return options;
}

}  // namespace lacuna::test
