// The two ways in which work can fail, and how each is said.
#pragma once

#include <stdexcept>
#include <string>

namespace lacuna {

/// Bad input or bad usage: the program ends with exit code 2. One line: where, what was found, what was expected.
class InputError : public std::runtime_error {
 public:
  /// `where` names file, line or key ("arm/scenario.yaml:12: actuators.joint_2.gain").
  InputError(const std::string& where, const std::string& found, const std::string& expected)
      : std::runtime_error(where + ": found " + found + ", expected " + expected) {}
};

/// The input is fine but the work could not be done (engine not built, nothing converged): exit code 3.
class WorkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Ctrl-C: partial results are kept and the run can be resumed: exit code 130.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; partial results are kept and the same command resumes") {}

 protected:
  using std::runtime_error::runtime_error;
};

/// A user's text as it may stand in a one-line message: control characters escaped, cut at `limit` characters.
std::string quoted(const std::string& text, std::size_t limit = 80);
/// The same, so that an lvalue does not find std::quoted, which fits it better.
inline std::string quoted(std::string& text, std::size_t limit = 80) {
  return quoted(static_cast<const std::string&>(text), limit);
}

}  // namespace lacuna
