// Conversions between NumPy arrays and the types of trephine::Operation, and errors as Python exceptions.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <vector>

#include "haptics/device/pose_path.h"
#include "sim/api/value.h"
#include "volume/base/error.h"

namespace trephine::python {

namespace py = pybind11;

/// Carries an Error to Python, where it becomes the exception `trephine.Error`.
struct PythonError {
  Error error;
};
[[noreturn]] inline void raise(const Error& error) { throw PythonError{error}; }
inline void check(const Status& status) {
  if (status) raise(*status);
}
template <class T>
T value_of(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(result).value();
}
/// Adds the exception class `Error` to the module.
void register_error(py::module_& module);

/// Raises an error for an array that could not be copied.
[[noreturn]] void raise_out_of_memory(const char* name);

[[noreturn]] inline void raise_wrong_type(const py::handle& value, const std::string& name,
                                          const char* expected) {
  raise({.what = "an argument has the wrong type",
         .where = name,
         .found = std::string(py::str(py::type::of(value))),
         .expected = expected});
}
/// Returns a Python object as a value of type T. If that is impossible, raises an error that names the
/// argument.
template <class T>
T argument(const py::handle& value, const std::string& name, const char* expected) {
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    raise_wrong_type(value, name, expected);
  } catch (const py::type_error&) {
    raise_wrong_type(value, name, expected);
  }
}
/// Returns a path or a text as a string. Raises an error for any other type.
std::string text_of(const py::handle& value, const std::string& name, const char* expected);

/// Returns three numbers as a vector. For any other shape, raises an error that names the argument.
glm::dvec3 vector_of(const py::handle& value, const char* name);
/// Returns three integers as a vector. Raises an error for fractions, for values beyond 2^20, and for any
/// other shape.
glm::ivec3 indices_of(const py::handle& value, const char* name);
py::tuple tuple_of(const glm::dvec3& v);
py::tuple tuple_of(const glm::dquat& q);  ///< w, x, y, z

/// Returns an array's numbers as doubles, without a copy if they are contiguous doubles, and sets `shape`.
/// The array must have 2 or 3 dimensions, the last of size `width`; otherwise raises an error that names the
/// argument and the expected shape.
py::array_t<double, py::array::c_style> doubles_of(const py::handle& value, const char* name, int width,
                                                   std::vector<py::ssize_t>& shape);

/// Returns the buttons, a bit each: one number for all poses, or one number per pose. `shape`: shape of the
/// positions; the buttons have this shape without its last dimension. Raises an error for fractions, negative
/// numbers and any other shape.
py::array_t<std::uint32_t, py::array::c_style> buttons_of(const py::handle& value,
                                                          const std::vector<py::ssize_t>& shape);

/// Returns keyword arguments in the words of commands: `diameter=3, round=True` as "diameter=3 round=yes".
/// Raises an error for a value that is not a number, text, truth value or sequence of these.
std::string words_of(const py::kwargs& keywords);
/// Returns the fields of a struct as a dict by name.
py::dict fields_of(const sim::Value& value);

}  // namespace trephine::python
