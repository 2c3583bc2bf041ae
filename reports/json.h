// Result records as JSON (FORMATS: diagnosis.json, fit.json). Numbers that are not finite become null; text that is not
// UTF-8 is replaced, never an error.
#pragma once

#include <span>
#include <string>

#include "diagnosis/diagnosis.h"
#include "reports/context.h"

namespace lacuna {

/// `diagnosis.json`, format lacuna-diagnosis/1.
std::string to_json(const Diagnosis& diagnosis, const Context& context);

/// Name of the file beside diagnosis.json with the commands that would separate the class of finding `number` (from 1).
std::string separation_file(std::size_t number);
/// File name of what is measured and predicted of the `number`th test recording: "predicted_1.csv".
std::string prediction_file(std::size_t number);

/// The context block alone.
std::string to_json(const Context& context);

/// `fit.json`, format lacuna-fit/1: one record per engine.
std::string to_json(std::span<const FitResult> fits, const std::string& scenario, const Context& context);
std::string to_json(const FitResult& fit, const std::string& scenario, const Context& context);

}  // namespace lacuna
