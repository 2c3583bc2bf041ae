// What stands in for an engine whose package was not there when Lacuna was built.
#pragma once

#include <utility>

#include "backends/engine.h"
#include "scenarios/error.h"

namespace lacuna {

class MissingEngine final : public Engine {
 public:
  /// `package` is the Debian package that was not found, `option` the CMake option that may have been off.
  MissingEngine(std::string name, const std::string& package, const std::string& option) : name_(std::move(name)) {
    reason_ = "not built in: when Lacuna was configured, " + package + " was not installed or " + option + " was OFF";
  }

  EngineInfo info() const override {
    EngineInfo info;
    info.name = name_;
    info.reason = reason_;
    return info;
  }
  std::unique_ptr<Dynamics> build(std::shared_ptr<const Robot>, const Eigen::Vector3d&) const override {
    throw WorkError("engine " + name_ + " is " + reason_);
  }

 private:
  std::string name_;
  std::string reason_;
};

}  // namespace lacuna
