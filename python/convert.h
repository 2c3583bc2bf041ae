// Between Python's objects and ours: numpy arrays without surprises in shape, result records as dicts, and long calls
// that let other threads run and end at Ctrl-C.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <cmath>
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

/// The same object with every list of numbers, however deep, as an array; None among them is nan. Lists of anything
/// else and empty ones stay lists.
inline py::object with_arrays(const py::object& value) {
  if (py::isinstance<py::dict>(value)) {
    py::dict out;
    for (const auto& [key, entry] : py::reinterpret_borrow<py::dict>(value))
      out[key] = with_arrays(py::reinterpret_borrow<py::object>(entry));
    return out;
  }
  if (!py::isinstance<py::list>(value)) return value;
  py::list out;
  std::vector<double> numbers;
  bool any = false;
  for (const auto& entry : py::reinterpret_borrow<py::list>(value)) {
    const bool number =
        (py::isinstance<py::float_>(entry) || py::isinstance<py::int_>(entry)) && !py::isinstance<py::bool_>(entry);
    any = any || number;
    if (number || entry.is_none()) numbers.push_back(entry.is_none() ? std::nan("") : entry.cast<double>());
    out.append(with_arrays(py::reinterpret_borrow<py::object>(entry)));
  }
  if (any && numbers.size() == out.size()) return array_of(numbers);
  return out;
}

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
