// The worst value seen in a comparison, and where.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace lacuna::test {

class Worst {
 public:
  Worst(std::string engine, std::string robot) : engine_(std::move(engine)), robot_(std::move(robot)) {}

  /// Not-a-number counts as infinitely bad.
  void see(double value, const std::string& where) {
    if (std::isnan(value)) value = INFINITY;
    if (value <= value_ && !where_.empty()) return;
    value_ = value;
    where_ = where;
  }
  double value() const { return value_; }

  testing::AssertionResult at_most(double tolerance) const {
    if (where_.empty()) return testing::AssertionFailure() << engine_ << ", " << robot_ << ": nothing was compared";
    const std::string words = engine_ + ", " + robot_ + ": worst " + testing::PrintToString(value_) + " at " + where_;
    // Kept in the test's XML report, so that agreement figures can be read off a passing run.
    testing::Test::RecordProperty(engine_ + "/" + robot_, words);
    if (value_ <= tolerance) return testing::AssertionSuccess() << words;
    return testing::AssertionFailure() << words << ", tolerance " << tolerance;
  }

 private:
  std::string engine_, robot_, where_;
  double value_ = 0.0;
};

}  // namespace lacuna::test
