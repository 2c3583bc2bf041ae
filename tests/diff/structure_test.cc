// What two diagnoses have in common, without a simulation.
#include "diff/structure.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lacuna {
namespace {

/// A diagnosis that names one effect, its numbers searched.
Diagnosis naming(const std::string& effect, const std::string& place, const std::vector<std::string>& members,
                 double probability, const std::map<std::string, double>& searched,
                 std::map<std::string, double> held = {}) {
  Diagnosis out;
  Finding f;
  f.effect = effect, f.place = place, f.members = members, f.probability = probability;
  out.findings.push_back(f);
  EffectSpec spec{effect, place, std::move(held), {}, ""};
  for (const auto& [key, value] : searched) {
    spec.parameters[key] = value;
    Estimate e;
    e.name = place + "." + effect + "." + key;
    out.after.estimates.push_back(e);
  }
  out.added.push_back(spec);
  return out;
}

TEST(CommonEffects, AreTheUnionOfBothSets) {
  std::vector<std::string> notes;
  const Diagnosis a = naming("coulomb_friction", "elbow", {"coulomb_friction"}, 0.9, {{"Fc", 2.0}}, {{"v0", 0.0}});
  const Diagnosis b = naming("valve_deadband", "elbow", {"valve_deadband"}, 0.9, {{"d", 0.1}});
  const std::vector<CommonEffect> out = common_effects(a, b, notes);
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(out[0].spec.effect, "coulomb_friction");
  EXPECT_EQ(out[0].spec.parameters, (std::map<std::string, double>{{"v0", 0.0}}));  // held, the other searched
  EXPECT_TRUE(out[0].a && !out[0].b);
  EXPECT_DOUBLE_EQ(out[0].a->values.at("Fc"), 2.0);
  EXPECT_TRUE(out[1].b && !out[1].a);
  EXPECT_TRUE(notes.empty());
}

TEST(CommonEffects, OfTwoThatAreNotToldApartTheMoreProbableStandsForBoth) {
  std::vector<std::string> notes;
  const Diagnosis a =
      naming("coulomb_friction", "elbow", {"coulomb_friction", "stribeck_friction"}, 0.6, {{"Fc", 2.0}});
  const Diagnosis b =
      naming("stribeck_friction", "elbow", {"stribeck_friction", "coulomb_friction"}, 0.9, {{"Fc", 2.1}, {"Fs", 2.5}});
  for (const auto& out : {common_effects(a, b, notes), common_effects(b, a, notes)}) {
    ASSERT_EQ(out.size(), 1u);
    EXPECT_EQ(out[0].spec.effect, "stribeck_friction");
    EXPECT_NE(std::find(out[0].look_alikes.begin(), out[0].look_alikes.end(), "coulomb_friction"),
              out[0].look_alikes.end());
  }
  EXPECT_EQ(notes.size(), 2u);
  // At another joint they are two.
  const Diagnosis elsewhere = naming("stribeck_friction", "shoulder", {"coulomb_friction"}, 0.9, {{"Fc", 2.1}});
  EXPECT_EQ(common_effects(a, elsewhere, notes).size(), 2u);
}

TEST(CommonEffects, WhatOneSetLeavesFreeIsFreeInBoth) {
  std::vector<std::string> notes;
  const Diagnosis a = naming("coulomb_friction", "elbow", {}, 0.9, {{"Fc", 2.0}}, {{"v0", 0.0}});
  const Diagnosis b = naming("coulomb_friction", "elbow", {}, 0.9, {{"Fc", 2.0}, {"v0", 0.01}});
  const std::vector<CommonEffect> out = common_effects(a, b, notes);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_TRUE(out[0].spec.parameters.empty());
  EXPECT_TRUE(out[0].a && out[0].b);
}

TEST(CommonEffects, LawsWithoutANameAreLeftOutAndSaid) {
  std::vector<std::string> notes;
  Diagnosis a;
  a.added.push_back({"learned_effort", "elbow", {}, {}, ""});
  EXPECT_TRUE(common_effects(a, Diagnosis{}, notes).empty());
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("learned_effort at elbow"), std::string::npos);
}

}  // namespace
}  // namespace lacuna
