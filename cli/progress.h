// The progress line on a terminal: bar, percent, stage, time left. Silent elsewhere and for work of under two seconds.
// Under mpirun there is no terminal, but whoever watches the log of a batch job: a line now and then.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "ga/optimizer.h"

namespace lacuna {

enum class ProgressStyle { terminal, log, none };
/// For the lines made from here on; where nothing is set they are for a terminal.
void set_progress_style(ProgressStyle style);

class ProgressLine {
 public:
  explicit ProgressLine(const std::string& stage);
  /// Clears the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void update(const std::string& stage, double done);
  /// For RunControl; the line must outlive it.
  std::function<void(const Progress&)> callback();

 private:
  struct State;
  std::unique_ptr<State> state_;  ///< null where nothing is to be drawn
};

}  // namespace lacuna
