// A made-up diagnosis with everything in it, and what tests look for in pages.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/diagnosis.h"
#include "diagnosis/resemblance.h"
#include "reports/context.h"

namespace lacuna::sample {

inline const double kNan = std::numeric_limits<double>::quiet_NaN();
inline const double kInf = std::numeric_limits<double>::infinity();

inline FitResult fit(double rms) {
  FitResult f;
  f.engine = "featherstone";
  f.optimizer = "ga+lsq";
  f.estimates = {{"joint_2.gain", "N m/V", 182.9, 182.0, 183.8, true, false, false},
                 {"link_6.mass", "kg", 1.2, -kInf, kInf, false, true, true}};
  f.point = {182.9, 1.2};
  f.identifiability.rank = 1;
  f.identifiability.condition = kInf;
  f.identifiability.undetermined = {{2.5, {0.0, 1.0}}};
  f.undetermined = {"1.00 link_6.mass"};
  for (const Role role : {Role::train, Role::validate, Role::test})
    f.rms.emplace_back(role, JointRms{{"joint_1", 3.1e-4}, {"joint_2", rms}});
  f.history = {{10.0, kInf, kInf, 1.0, 70, 0.1}, {2.0, 8.0, 9.0, 0.5, 140, 0.2}};
  f.step = {0.0025, 0.03};
  f.seconds = 4.5;
  return f;
}

inline Finding finding() {
  Finding f;
  f.effect = "coulomb_friction";
  f.place = "joint_2";
  f.probability = 0.98;
  f.rivals = {{"stribeck_friction", "joint_2", 0.02}};
  f.members = {"coulomb_friction", "stribeck_friction"};
  f.parameters = {{"Fc", "N m", 24.7, 23.9, 25.5, true, false, false}};
  f.times = {{"train_1.csv", 2.1, 2.4}, {"train_2.csv", 5.0, 5.5}};
  f.regions = {"joint_2 velocity sign changes"};
  f.p_value = 1e-12;
  f.heldout_gain = 1234.5;
  f.heldout_error = 88.0;
  f.heldout_share = 0.93;
  f.stability = 0.97;
  return f;
}

/// A ripple that repeats itself over the position, or a drag that does not over the speed, as learned.
inline LearnedLaw learned_law(bool ripple = true) {
  LearnedLaw law;
  law.place = "joint_2", law.unit = "N m";
  law.over = {{ripple ? "q" : "v", -1.0, 1.0, ripple ? "rad" : "rad/s", 33}};
  law.period = ripple ? 0.5 : 0.0;
  for (int k = 0; k <= 32; ++k) {
    const double at = -1.0 + k / 16.0;
    const double value = ripple ? 0.2 * std::sin(4.0 * std::numbers::pi * at) : -0.8 * at * std::fabs(at);
    law.curve.push_back({at, value, value - 0.01, value + 0.01});
  }
  law.probability = 0.97, law.evidence = 850.0;
  law.heldout_gain = 1234.5, law.heldout_share = 0.94;
  describe_curve(law);
  return law;
}

inline MissingEffort missing_effort() {
  MissingEffort m;
  m.joint = "joint_2", m.unit = "%";
  m.rms = 0.5, m.noise = 0.01, m.share = 1.0, m.p_value = 1e-40;
  m.regions = {{"near standstill", 3.0, 1e-9}};
  m.follows = {{"the direction of motion", -0.9, 1e-20}};
  m.changes = {{"train_1.csv", 1.0, 0.2, 0.7, 1e-8}, {"train_2.csv", 3.0, 0.7, 0.1, 1e-5}};
  m.recording = "train_1.csv";
  m.time = {0.0, 1.0, 2.0}, m.trace = {0.1, -0.5, 0.6};
  return m;
}

/// Of a valve with a dead zone and one stop.
inline ValveComparison valve() {
  ValveChart chart;
  chart.name = "joint_2", chart.delay = 0.1, chart.command = {-2.0, -1.0, 0.0, 1.0, 2.0};
  chart.speed = {-0.2, 0.0, 0.0, 0.0, 0.3}, chart.seen = {4.0, 2.0, 9.0, 2.0, 3.0};
  chart.stops[1] = 0.7, chart.rms = {{Role::test, 0.01}};
  return {chart, chart};
}

inline Trace trace(const std::string& joint) {
  Trace t{"test_1.csv", joint, "rad", {}, {}, {}, {}};
  for (int i = 0; i < 4000; ++i) {
    const double x = 0.005 * i;
    t.time.push_back(x);
    t.measured.push_back(i == 100 ? kNan : std::sin(x));
    t.before.push_back(std::sin(x) + 0.01);
    t.after.push_back(std::sin(x) + 1e-4);
  }
  return t;
}

inline Diagnosis diagnosis() {
  Diagnosis d;
  d.scenario = "d03";
  d.engine = "featherstone";
  d.verdict = Verdict::missing_physics;
  d.findings = {finding()};
  d.unexplained.share = 0.02;
  d.noise = {{"joint_1", 3e-4}, {"joint_2", 3e-4}};
  d.before = fit(1.2e-3);
  d.after = fit(3.03e-4);
  d.rounds = {{{"coulomb_friction", "joint_2", 3000.0, 1234.5, 88.0, 0.93, 1e-12, 1, ""},
               {"input_delay", "joint_1", 0.5, kNan, kNan, 0.0, 1.0, 1, "no better than chance"}}};
  d.engines = {{"featherstone", true, "", d.before.rms[2].second, d.after.rms[2].second, 1.0},
               {"ode", false, "not built", {}, {}, 0.0}};
  d.missing = {missing_effort()};
  d.valves = {valve()};
  d.whiteness = {{"joint_1", Role::test, 4000.0, {0.1, 0.05}, {0.1, 0.04}, 0.3, 0.3},
                 {"joint_2", Role::test, 4000.0, {0.9, 0.8}, {0.02, -0.01}, 0.0, 0.6}};
  d.traces = {trace("joint_1"), trace("joint_2")};
  d.notes = {"validate_1.csv: 3 missing values left out"};
  d.seconds = 12.3;
  return d;
}

inline Context context() {
  Context c;
  c.date = "2025-01-02T03:04:05Z";
  c.host = "host";
  c.cpu = "cpu";
  c.cores = 2;
  c.compiler = "GNU 12.2.0";
  c.flags = "-O3";
  c.build_type = "Release";
  c.commit = "abc1234";
  c.version = "0.1.0";
  c.lanes = "avx2 x 4";
  c.engine_versions = {{"featherstone", "0.1.0"}};
  c.seed = 7;
  c.threads = 2;
  c.command_line = "lacuna diagnose scenario.yaml";
  return c;
}

/// Nothing that has a name, and laws in its place.
inline Diagnosis learned_diagnosis(std::vector<LearnedLaw> laws) {
  Diagnosis d = diagnosis();
  d.verdict = Verdict::unknown_physics;
  d.findings.clear();
  d.unexplained = {true, {"joint_2"}, {}, {}, 0.9, 0.0, {}};
  d.learned = std::move(laws);
  return d;
}

/// Something that happened once, of one kind: 0.5 s of it.
inline LearnedEvent learned_event(EventSpec::Kind kind = EventSpec::Kind::effort) {
  LearnedEvent e;
  e.kind = kind;
  e.place = "joint_2", e.recording = "train_1.csv", e.role = Role::train;
  e.from = 6.1, e.to = 6.6, e.evidence = 850.0;
  switch (kind) {
    case EventSpec::Kind::effort: e.value = 12.0, e.unit = "N m", e.resembles = "a push"; break;
    case EventSpec::Kind::command: e.value = 0.0, e.unit = "%", e.resembles = "a lost command"; break;
    default: e.value = 0.02, e.unit = "rad", e.resembles = "a slip of the transducer";
  }
  e.pieces = {{kind, e.place, e.recording, e.from, e.to, e.value, 0.0, "learned"}};
  return e;
}
inline LearnedEvent learned_event_in(const std::string& recording, Role role) {
  LearnedEvent e = learned_event();
  e.recording = e.pieces.front().file = recording;
  e.role = role;
  return e;
}

/// Nothing that has a name, and events in its place.
inline Diagnosis eventful_diagnosis(std::vector<LearnedEvent> events) {
  Diagnosis d = learned_diagnosis({});
  d.events = std::move(events);
  return d;
}

/// Every string in it is an attack on the page.
/// Of joint_3's valve, whose null moved by half a volt.
inline NumberByRecording number_by_recording() {
  return {"joint_3", "valve_offset.b", "V", 0.1, 0.25, 31.0, 0.4, {{"train_1.csv", -0.2}, {"validate_1.csv", 0.3}}};
}

inline Diagnosis hostile_diagnosis() {
  const std::string attack = "<script>alert('x')</script>\"&\xff\x01";
  Diagnosis d = diagnosis();
  d.scenario = d.engine = attack;
  Finding& f = d.findings.front();
  f.effect = f.place = attack;
  f.rivals = {{attack, attack, 0.1}};
  f.members = {attack, attack + "2"};
  f.recordings = f.regions = {attack};
  f.times = {{attack, 0.0, 1.0}};
  f.parameters.front().name = f.parameters.front().unit = attack;
  d.unexplained = {true, {attack}, {attack}, {{attack, attack, 0.0, 1.0, 3.0, 1e-9}}, 0.5, 0.0, {}};
  d.unexplained.numbers = {{attack, attack, attack, 1.0, 0.1, 20.0, 0.3, {{attack, 0.1}}}};
  LearnedLaw law = learned_law();
  law.place = law.unit = law.over.front().unit = law.over.front().name = attack;
  describe_curve(law);
  d.learned = {law};
  LearnedEvent event = learned_event();
  event.place = event.recording = event.unit = event.resembles = attack;
  d.events = {event};
  d.noise.front().first = attack;
  for (FitResult* result : {&d.before, &d.after}) {
    result->engine = result->optimizer = attack;
    result->undetermined = {attack};
    result->estimates.front().name = result->estimates.front().unit = attack;
    for (auto& [role, rms] : result->rms) rms.front().first = attack;
  }
  d.rounds.front().front() = {attack, attack, 1.0, 1.0, 1.0, 1.0, 1.0, 1, attack};
  d.engines = {{attack, false, attack, {}, {}, 0.0}, {attack, true, "", {{attack, 1.0}}, {{attack, 1.0}}, 1.0}};
  for (Whiteness& w : d.whiteness) w.joint = attack;
  MissingEffort& m = d.missing.front();
  m.joint = m.recording = m.regions.front().region = m.follows.front().quantity = attack;
  for (EffortChange& c : m.changes) c.recording = attack;
  for (Trace& t : d.traces) t.recording = t.joint = t.unit = attack;
  for (ValveComparison& v : d.valves) v.recorded.name = v.simulated.name = attack;
  d.notes = {attack};
  return d;
}

}  // namespace lacuna::sample
