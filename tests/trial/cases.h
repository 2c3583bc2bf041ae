// Cases with verdicts and labels, made up.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "trial/score.h"

namespace lacuna::test {

inline BlindVerdict::Claim claim(const std::string& effect, const std::string& place, double probability = 0.95) {
  return {effect, place, probability, {effect}};
}

inline BlindCase one_case(std::vector<BlindLabel::Effect> hidden, const std::string& verdict,
                          std::vector<BlindVerdict::Claim> claims = {}) {
  BlindCase out;
  out.name = "case";
  out.label = BlindLabel{std::move(hidden), 2.0};
  out.verdict.emplace();
  out.verdict->verdict = verdict;
  out.verdict->claims = std::move(claims);
  out.verdict->noise = {{"joint_1", 1.0}, {"joint_2", 1.0}};
  out.verdict->train = out.verdict->before = {{"joint_1", 1.0}, {"joint_2", 3.0}};
  out.verdict->after = {{"joint_1", 1.0}, {"joint_2", 2.0}};
  out.verdict->effective_samples = 100.0;
  out.verdict->seconds = 2.0;
  return out;
}

inline const BlindLabel::Effect kFriction{"coulomb_friction", "joint_2", 25.0}, kDelay{"input_delay", "joint_1", 0.02},
    kRipple{"position_ripple", "joint_1", 6.0};

}  // namespace lacuna::test
