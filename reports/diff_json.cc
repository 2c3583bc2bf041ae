#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/diff.h"
#include "reports/json.h"
#include "reports/json_text.h"

namespace lacuna {
namespace {

using DiffJson = nlohmann::ordered_json;

DiffJson value_with_interval(const Estimate& e) { return {{"value", e.value}, {"ci95", {e.lower95, e.upper95}}}; }

DiffJson number_of_change(const ChangedNumber& n) {
  return {{"parameter", n.key},
          {"a", value_with_interval(n.a)},
          {"b", value_with_interval(n.b)},
          {"difference", value_with_interval(n.difference)},
          {"unit", n.b.unit}};
}

/// The leading number's values stand at the change itself, those of all of them under `numbers`.
DiffJson record_of(const MachineChange& change) {
  DiffJson out{{"name", change.name}, {"where", change.place}};
  if (!change.effect.empty()) out["effect"] = change.effect;
  out.update(number_of_change(change.numbers.front()));
  out["probability"] = change.probability;
  out["class"] = change.members;
  out["class_probability"] = change.class_probability;
  out["look_alikes"] = change.look_alikes;
  if (!change.recordings.empty()) out["recordings"] = change.recordings;
  for (const ChangedNumber& n : change.numbers) out["numbers"].push_back(number_of_change(n));
  out["evidence"] = {{"heldout_gain", change.heldout_gain},
                     {"heldout_gain_error", change.heldout_error},
                     {"heldout_share", change.heldout_share}};
  return out;
}

DiffJson rms_record(const JointRms& rms) {
  DiffJson out = DiffJson::object();
  for (const auto& [joint, value] : rms) out[joint] = value;
  return out;
}

DiffJson record_of(const DiffSet& set) {
  DiffJson fit = DiffJson::object(), joints = DiffJson::object();
  for (const DiffFit& f : set.fit)
    fit[to_string(f.role)] = {
        {"model_a", rms_record(f.of_a)}, {"model_b", rms_record(f.of_b)}, {"shared_and_changed", rms_record(f.joint)}};
  for (const Unexplained::AtJoint& at : set.unexplained.per_joint)
    joints[at.joint] = {{"rms_over_noise", at.over_noise}, {"probability", at.probability}};
  return {
      {"scenario", set.name},
      {"verdict", to_string(set.verdict)},
      {"findings", set.findings},
      {"noise", rms_record(set.noise)},
      {"fit", fit},
      {"unexplained", {{"present", set.unexplained.present}, {"where", set.unexplained.where}, {"per_joint", joints}}}};
}

DiffJson record_of(const HeldoutGainOver& g) { return {{"gain", g.gain}, {"error", g.error}, {"share", g.share}}; }

}  // namespace

std::string to_json(const Diff& diff, const Context& context) {
  DiffJson changes = DiffJson::array(), refused = DiffJson::array(), shared = DiffJson::array();
  for (const MachineChange& change : diff.changes) changes.push_back(record_of(change));
  for (const RefusedChange& r : diff.refused)
    refused.push_back({{"name", r.name}, {"probability", r.probability}, {"reason", r.reason}});
  for (const SharedNumber& s : diff.shared) {
    DiffJson one{{"parameter", s.pooled.name}};
    one.update(value_with_interval(s.pooled));
    one["unit"] = s.pooled.unit;
    one["identifiable"] = s.pooled.identifiable;
    one["probability_changed"] = s.changed;
    shared.push_back(one);
  }
  return json_text({{"format", "lacuna-diff/1"},
                    {"scenarios", {diff.a.name, diff.b.name}},
                    {"engine", diff.engine},
                    {"seed", diff.seed},
                    {"version", context.version},
                    {"verdict", to_string(diff.verdict)},
                    {"changes", changes},
                    {"not_claimed", refused},
                    {"shared", shared},
                    {"probability_of_no_change", diff.no_change},
                    {"log_evidence", diff.evidence},
                    {"heldout",
                     {{"changed_over_same", record_of(diff.changed_over_same)},
                      {"own_over_shared_and_changed", record_of(diff.own_over_joint)}}},
                    {"rest_in_one", {{"a", diff.rest_in_a}, {"b", diff.rest_in_b}}},
                    {"a", record_of(diff.a)},
                    {"b", record_of(diff.b)},
                    {"notes", diff.notes},
                    {"seconds", diff.seconds},
                    {"context", DiffJson::parse(to_json(context))}});
}

}  // namespace lacuna
