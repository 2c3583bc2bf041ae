// Between Python's objects and ours: numpy arrays without surprises in shape, result records as dicts, and long calls
// that let other threads run and end at Ctrl-C.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <future>
#include <span>
#include <string>
#include <vector>

#include "physics/executor.h"

namespace lacuna {

namespace py = pybind11;

/// Numbers in C order; anything that numpy can turn into them is taken.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

inline std::span<const double> span_of(const Array& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}
inline Array array_of(const std::vector<double>& numbers) {
  return Array(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

/// A result record, as the program writes it with --json, as dicts and lists; null is None.
inline py::object dict_of(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

/// Runs `work(stop)` on a thread of its own, without the interpreter's lock, and returns what it returns. Meanwhile
/// Python's signal handlers run: where one raises (Ctrl-C: KeyboardInterrupt), `stop` is set, the work is awaited, and
/// what was raised goes on. `work` must not touch Python.
template <class Work>
auto interruptible(const Work& work) {
  constexpr std::chrono::milliseconds kLook{20};
  StopFlag stop{false};
  auto result = std::async(std::launch::async, [&] { return work(stop); });
  const auto ready = [&](std::chrono::milliseconds wait) {
    const py::gil_scoped_release others;
    return result.wait_for(wait) == std::future_status::ready;
  };
  while (!ready(kLook)) {
    if (PyErr_CheckSignals() == 0) continue;
    py::error_already_set raised;  // taken before the lock is given away
    stop.store(true);
    {
      const py::gil_scoped_release others;
      result.wait();
    }
    throw raised;
  }
  return result.get();
}

}  // namespace lacuna
