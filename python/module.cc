// `import lacuna`: the engines, robots, scenarios, simulations and searches of the library, for Python.
#include "reports/context.h"
#include "scenarios/error.h"
#include "scenarios/files.h"
#include "python/convert.h"
#include "python/room.h"

PYBIND11_MODULE(lacuna, module) {
  module.doc() = "Multibody engines, identification and diagnosis of robot recordings (docs/python.md).";
  module.attr("__version__") = lacuna::version();
  pybind11::register_exception<lacuna::InputError>(module, "InputError", PyExc_ValueError).doc() =
      "Bad input; one line: where, what was found, what was expected.";
  pybind11::register_exception<lacuna::WorkError>(module, "WorkError", PyExc_RuntimeError).doc() =
      "The input is fine but the work could not be done.";
  pybind11::register_exception<lacuna::WriteError>(module, "WriteError", PyExc_OSError).doc() =
      "A file that cannot be written, with the system's reason.";
  lacuna::add_dynamics(module);
  lacuna::add_simulator(module);
  lacuna::add_searches(module);
}
