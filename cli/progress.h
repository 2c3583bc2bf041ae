// The progress line on a terminal: bar, percent, stage, time left. Silent elsewhere and for work of under two seconds.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "ga/optimizer.h"

namespace lacuna {

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
