// The sections of scenario.yaml, each read and checked in form. Recordings are loaded elsewhere.
#pragma once

#include <string>

#include "scenarios/scenario.h"
#include "scenarios/yaml_reader.h"

namespace lacuna {

class ScenarioParser {
 public:
  /// Fills a Scenario whose `file` is set; `root` is the document.
  ScenarioParser(const YamlCursor& root, Scenario& out) : root_(root), out_(out) {}

  /// Everything but the recordings' data. Throws InputError.
  void parse();

 private:
  void parse_head();
  void parse_robot();
  void parse_actuators(const YamlCursor& section);
  void parse_identify(const YamlCursor& section);
  void parse_channels(const YamlCursor& section);
  void parse_kind(ChannelKind kind, const YamlCursor& section);
  void parse_noise(const YamlCursor& section);
  void parse_recordings(const YamlCursor& section);
  void parse_effects(const YamlCursor& section);
  void parse_payloads(const YamlCursor& section);
  void note_unused_pressures();
  void note_commands_before_pressures();
  void note_unused();
  void parse_prediction(const YamlCursor& section);
  void parse_pressure_driven(const YamlCursor& section);
  void parse_motion(const YamlCursor& section);

  EffectSpec parse_effect(const YamlCursor& entry) const;
  void expect_recording(const std::string& file, const YamlCursor& at) const;
  void parse_events(const YamlCursor& entry, EventSpec::Kind kind);
  RecordingSpec parse_recording(const YamlCursor& entry) const;
  RecordingPart parse_part(const YamlCursor& entry) const;
  void expect_joint(const std::string& name, const YamlCursor& at) const;
  void refuse_shared_columns() const;
  void note_overlaps();

  YamlCursor root_;
  Scenario& out_;
};

/// Resolves a path written in the scenario against its folder.
std::filesystem::path resolve(const Scenario& scenario, const std::string& written);

}  // namespace lacuna
